// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <optional>

#include "slalom/local_planner/LocalPlanner.h"

namespace slalom::local_planner::detail
{
/// P_tn [Paper Algorithm 1]: what the NMPC follows. Columns as in NmpcData.
struct HorizonReference
{
  Eigen::Matrix4Xd states;  ///< 4x(N+1): position [m], yaw [rad, continuous]
  Eigen::Matrix4Xd inputs;  ///< 4xN: velocity [m/s], yaw rate [rad/s]
  Eigen::Vector3d acceleration = Eigen::Vector3d::Zero();  ///< of stage 0 [m/s^2]
  double heading = 0.0;  ///< [rad] of stage 0, to be held when the reference rests
};

/** Samples the reference as its time law runs from `progress` on.
 *
 *  The input of stage k is the velocity in the middle of its interval: it is held for the whole
 * interval, so the middle is what leads from one reference point to the next. The heading follows
 * the horizontal velocity the short way round; slower than yaw_hold_speed it holds, at first
 * `held_heading` or, without one, the vehicle's own. */
[[nodiscard]] HorizonReference sampleHorizon(const LocalPlannerInput& input,
                                             const LocalPlannerConfig& config,
                                             const core::Vehicle& vehicle,
                                             std::optional<double> held_heading);

}  // namespace slalom::local_planner::detail
