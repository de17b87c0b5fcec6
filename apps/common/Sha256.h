// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace slalom::app
{
[[nodiscard]] std::string sha256OfText(std::string_view text);  ///< lower-case hex
/// Empty if the file cannot be read.
[[nodiscard]] std::string sha256OfFile(const std::filesystem::path& file);

}  // namespace slalom::app
