// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "slalom/core/DistanceField.h"

namespace slalom::bench
{
/// One question to the search, in a field as the mapper makes it.
struct SearchProblem
{
  std::shared_ptr<const core::DistanceField> field;
  Eigen::Vector3d start_L, goal_L;
  Eigen::AlignedBox3d box_L;
};

/// Trunks of 0.15-0.35 m, straight up; solvable, with no straight way.
[[nodiscard]] std::vector<SearchProblem> forests(double trees_per_m2, std::size_t count);
/// Thin trunks under broad crowns, which begin at 1.4-2.4 m; otherwise likewise.
[[nodiscard]] std::vector<SearchProblem> crowns(double trees_per_m2, std::size_t count);
/// Out of a U of walls, to a goal behind its back.
[[nodiscard]] std::vector<SearchProblem> uTraps(std::size_t count);
/// Through a wall with two gaps, of different width.
[[nodiscard]] std::vector<SearchProblem> twoGaps(std::size_t count);
/// Forests with a closed ring of wall around the start (odd) or the goal (even).
[[nodiscard]] std::vector<SearchProblem> unreachable(std::size_t count);
/// The same problems with the full height of the map as their box.
[[nodiscard]] std::vector<SearchProblem> tall(std::vector<SearchProblem> problems);
}  // namespace slalom::bench
