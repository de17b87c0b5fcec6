// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>

#include "slalom/simulation/World.h"

namespace slalom::simulation::detail
{
/// Header `x,y,radius,height`, one tree a line. @throws std::runtime_error naming file, line, value
[[nodiscard]] Shapes readTrees(const std::filesystem::path& file);

/// The sections that World.h lists. @throws mrpt_io::ConfigError naming file, line, key
[[nodiscard]] Shapes readIniWorld(const std::filesystem::path& file, std::uint64_t seed);

}  // namespace slalom::simulation::detail
