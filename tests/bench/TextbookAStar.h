// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "slalom/search/GridSearch.h"

namespace slalom::bench
{
struct TextbookResult
{
  bool found = false;
  double cost = 0.0;      ///< of the lattice path, exactly the smallest
  double length_m = 0.0;  ///< of the lattice path, not shortcut
};

/// A* as in any textbook, on the lattice and with the costs of search::findPath: the baseline.
[[nodiscard]] TextbookResult textbookAStar(const core::DistanceField& field,
                                           const Eigen::Vector3d& start_L,
                                           const Eigen::Vector3d& goal_L,
                                           const Eigen::AlignedBox3d& box_L,
                                           const search::GridSearchConfig& config);
}  // namespace slalom::bench
