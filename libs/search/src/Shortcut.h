// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <vector>

#include "slalom/search/GridSearch.h"

namespace slalom::search::detail
{
/// A polyline and its cost.
struct PricedPath
{
  std::vector<Eigen::Vector3d> points;
  double cost = 0.0;  ///< [m]
};

/** Pulls a path straight: from each point kept, on to the farthest later point that is in sight
 * with the hard clearance and not dearer than the way it replaces. Pieces of the path that are kept
 * as they are are not checked. */
[[nodiscard]] PricedPath shortcut(const core::DistanceField& field,
                                  const std::vector<Eigen::Vector3d>& path,
                                  const GridSearchConfig& config);
}  // namespace slalom::search::detail
