// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <optional>

#include "slalom/core/DistanceField.h"

namespace slalom::search
{
struct GridSearchConfig
{
  double clearance_m =
      0.5;  ///< [m] hard: cells nearer than this to an obstacle are closed (optimistic field)
  double preferred_clearance_m =
      0.8;  ///< [m] cells nearer than this cost more, so that wide gaps win over narrow ones
  double proximity_weight =
      2.0;                      ///< [1] extra cost per metre travelled at zero preferred clearance
  double unknown_weight = 0.0;  ///< [1] a metre of space that was never seen costs at least this
                                ///< much more, at most proximity_weight
  int max_expansions = 200000;  ///< [1] cap of grid points; the result is then "not found"
  double max_detour = 1.8;      ///< [1] an alternative may cost this times the first path
  int max_alternative_expansions = 6000;  ///< [1] cap of all alternatives together
};

enum class SearchStatus
{
  Found,
  StartBlocked,
  GoalBlocked,
  Unreachable,
  ExpansionLimit
};

struct SearchResult
{
  SearchStatus status = SearchStatus::Unreachable;
  Eigen::Matrix3Xd
      path;  ///< from start to goal, shortcut, both included exactly; empty unless Found
  double length_m = 0.0;
  double cost_m = 0.0;  ///< [m] length weighted by nearness to obstacles, >= length_m
  int expansions = 0;   ///< grid points expanded
  Eigen::Vector3d
      nearest_L;  ///< reached cell nearest to the goal; what "approach and hold" can use
};

/** A* over the 26-connected grid of the field's resolution inside `box_L` and the field's bounds,
 * with the start as a grid point, then shortcutting by line-of-sight checks against the same
 * clearance that do not raise the cost. Unknown space counts as free here (guides are optimistic).
 * Deterministic: the same input gives the same path, to the bit.
 *
 *  A metre costs 1 + proximity_weight (preferred - d) / (preferred - clearance) between the hard
 * and the preferred clearance, and where space was never seen at least 1 + unknown_weight: what
 * hides there is found out only on the way. Before shortcutting the cost is at most 1.05 times the
 * grid's optimum. Start and goal need the clearance where they are. If the goal has not, or if it
 * is cut off, nearest_L is the grid point nearest to it that can be reached.
 *
 *  The search is led by what the way costs at least as seen from above, which relies on distances
 * that grow by no more than one metre per metre. Thread-safe; each thread keeps some memory for its
 * next call (16 bytes per grid point of the largest box it has searched, at most 64 MB).
 *  @throws std::invalid_argument on a negative or non-finite clearance or weight, or if
 *  unknown_weight is above proximity_weight
 *  @see deviation D-04 (docs/paper_map.md): the guide that [Paper Eq. (2)] silently needs */
[[nodiscard]] SearchResult findPath(const core::DistanceField& field,
                                    const Eigen::Vector3d& start_L, const Eigen::Vector3d& goal_L,
                                    const Eigen::AlignedBox3d& box_L,
                                    const GridSearchConfig& config);

/// True if every point of the segment keeps `clearance_m` in the optimistic field (sphere marching,
/// exact up to 1e-3 m).
[[nodiscard]] bool segmentClear(const core::DistanceField& field, const Eigen::Vector3d& a_L,
                                const Eigen::Vector3d& b_L, double clearance_m);

}  // namespace slalom::search
