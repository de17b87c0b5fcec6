// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "Lattice.h"
#include "slalom/search/GridSearch.h"

namespace slalom::search::detail
{
/// A polyline and its cost.
struct PricedPath
{
  Path points;
  double cost = 0.0;  ///< [m]
};

/** Pulls a path straight: from each point kept, on to the farthest later point that is in sight
 * with the hard clearance, across none of the walls and not dearer than the way it replaces. Pieces
 * of the path that are kept as they are are not checked. */
[[nodiscard]] PricedPath shortcut(const core::DistanceField& field, const Path& path,
                                  const GridSearchConfig& config, const Lattice& lattice,
                                  Walls walls);
}  // namespace slalom::search::detail
