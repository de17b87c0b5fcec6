// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

#include "slalom/core/DistanceField.h"
#include "slalom/spline/UniformBSpline.h"

namespace slalom::global_planner
{
constexpr Eigen::Index kFixedAtStart =
    4;  ///< the span under the vehicle keeps its four control points
constexpr Eigen::Index kFixedAtEnd = 3;  ///< position, velocity and acceleration join R

/// What one step works on: the part of R ahead of the vehicle, and its control points.
struct PlanningWindow
{
  double from = 0.0, to = 0.0;        ///< [s]
  Eigen::Index first = 0, count = 0;  ///< control points first .. first + count - 1
  bool blocked_end = false;           ///< R beyond `to` is occupied as far as the map reaches
  bool goal_blocked = false;          ///< ... including its very end

  [[nodiscard]] Eigen::Index firstFree() const { return kFixedAtStart; }
  [[nodiscard]] Eigen::Index lastFree() const { return count - 1 - kFixedAtEnd; }
  [[nodiscard]] bool hasFreePoints() const { return lastFree() >= firstFree(); }
};

/** At least `horizon_m` of R from `progress` on, then farther until R has been free for some knots,
 * so that the refined curve has room to come back to it; never beyond the map. Where R ends
 * blocked, the window ends before the blockage.
 *  @param free_distance optimistic distance from which R counts as free [m] */
[[nodiscard]] PlanningWindow choosePlanningWindow(const spline::UniformBSpline& r, double progress,
                                                  double horizon_m,
                                                  const core::DistanceField& field,
                                                  double free_distance);

/// Distance with unknown space as free; the field's maximum outside the map [m].
[[nodiscard]] double optimisticDistance(const core::DistanceField& field,
                                        const Eigen::Vector3d& p_L);

}  // namespace slalom::global_planner
