// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <vector>

#include "slalom/core/DistanceField.h"

namespace slalom::local_planner::detail
{
/// What a step knows of the obstacles around its expected motion.
struct CloseObstacles
{
  Eigen::Matrix3Xd anchors;  ///< 3x(N+1) [m] where each stage's distances are linearised
  std::vector<Eigen::Vector3d> points_L;  ///< C_o [m] on surfaces, none within 0.1 m of another
  bool finite = true;  ///< false: the field answered with a number that is not finite
};

/** GetCloseInObstacles(P_tn, M) [Paper Algorithm 1] along the expected positions of the stages.
 *
 *  Anchors follow the expected positions as long as these keep `radius` from obstacles, or get no
 *  deeper than they are; from the first stage that would collide on, the last good anchor stays:
 *  what lies behind an obstacle must not be asked for from its far side. The nearest obstacle point
 *  of every anchor, and of a probe on its other side, is kept if nearer than `reach`. The field
 *  gives distance d and direction g; the point is p - d g. Inside an obstacle it is a point just
 *  behind p, so that "away from the point" leads out. Unknown space counts as free, and what is
 *  outside the field is not seen.
 *  @param expected 3x(N+1) [m], the first one is the vehicle */
[[nodiscard]] CloseObstacles collectCloseObstacles(const core::DistanceField& field,
                                                   const Eigen::Matrix3Xd& expected, double radius,
                                                   double reach);

/** The at most `count` obstacles that bound the motion around p: the nearest first, then the
 * nearest in a clearly different direction. Only those within `reach`. */
[[nodiscard]] std::vector<Eigen::Vector3d> nearestAround(const Eigen::Vector3d& p,
                                                         const std::vector<Eigen::Vector3d>& points,
                                                         int count, double reach);

}  // namespace slalom::local_planner::detail
