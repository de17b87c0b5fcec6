// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "slalom/mrpt_io/Diagnosis.h"

namespace slalom::doctor
{
/// What is wrong with a configuration file and the assignments on top of it.
[[nodiscard]] std::vector<mrpt_io::Finding> examineConfig(
    const std::filesystem::path& file, const std::vector<std::string>& assignments);

}  // namespace slalom::doctor
