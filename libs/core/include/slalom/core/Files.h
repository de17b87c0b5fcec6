// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>

namespace slalom::core
{
/** True where nothing or a regular file is. Files that appear by renaming would otherwise put a
 * file in the place of a device or a pipe. Links are followed; a place that cannot be examined
 * counts as free, because opening it says why. */
[[nodiscard]] inline bool mayBeReplaced(const std::filesystem::path& file)
{
  using std::filesystem::file_type;
  std::error_code ignored;
  const file_type type = std::filesystem::status(file, ignored).type();
  return type == file_type::regular || type == file_type::not_found || type == file_type::none;
}

}  // namespace slalom::core
