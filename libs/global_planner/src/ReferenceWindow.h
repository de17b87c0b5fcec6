// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "slalom/core/DistanceField.h"
#include "slalom/spline/UniformBSpline.h"

namespace slalom::global_planner
{
/// The part of R that one step looks at. Both ends lie on knots of R.
struct ReferenceWindow
{
  Eigen::Index first_knot = 0, last_knot = 0;
  double from = 0.0, to = 0.0;  ///< [s] times of these knots
  bool goal_blocked = false;    ///< R is occupied from `to` to its very end

  /// R's control point with this index is the last one that shapes the window.
  [[nodiscard]] Eigen::Index lastPoint() const { return last_knot + 2; }
};

/** At least `horizon_m` of R from `progress` on, then farther until R has been free for some knots,
 * so that a plan has room to come back to it; never beyond the map. Where R ends blocked, the
 * window ends before the blockage.
 *  @param free_distance optimistic distance from which R counts as free [m] */
[[nodiscard]] ReferenceWindow chooseWindow(const spline::UniformBSpline& r, double progress,
                                           double horizon_m, const core::DistanceField& field,
                                           double free_distance);

/// Distance with unknown space as free; the field's maximum outside the map [m].
[[nodiscard]] double optimisticDistance(const core::DistanceField& field,
                                        const Eigen::Vector3d& p_L);

}  // namespace slalom::global_planner
