// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <vector>

#include "slalom/simulation/Shapes.h"

namespace slalom::simulation::detail
{
/// What a csv or ini world says.
struct WorldShapes
{
  std::vector<Tree> trees;
  std::vector<Box> boxes;
  bool ground = true;
};

/// Header `x,y,radius,height`, one tree a line. @throws std::runtime_error naming file, line, value
[[nodiscard]] WorldShapes readTrees(const std::filesystem::path& file);

/// Sections [tree.NAME], [box.NAME], [world]. @throws mrpt_io::ConfigError naming file, line, key
[[nodiscard]] WorldShapes readIniWorld(const std::filesystem::path& file);

}  // namespace slalom::simulation::detail
