// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <optional>

#include "slalom/local_planner/LocalPlanner.h"

namespace slalom::local_planner::detail
{
/// P_tn [Paper Algorithm 1]: what the NMPC follows, sampled as its time law runs.
struct HorizonReference
{
  Eigen::Matrix3Xd positions;   ///< 3x(N+1) [m], at the ends of the stages
  Eigen::Matrix3Xd velocities;  ///< 3x(N+1) [m/s]
  Eigen::Matrix3Xd commands;    ///< 3xN [m/s] that lead from point to point, lag and disturbance
                                ///< accounted for
  Eigen::VectorXd yaw;          ///< N+1 [rad], continuous
  Eigen::VectorXd yaw_rates;    ///< N [rad/s]
  Eigen::Vector3d acceleration = Eigen::Vector3d::Zero();  ///< [m/s^2] at the start
  double heading = 0.0;  ///< [rad] of stage 0, to be held when the reference rests
};

/** Samples the reference from `progress` on.
 *
 *  A command is held over its stage, so the reference's velocity in the middle of the stage is what
 *  leads from one point to the next; the vehicle's lag adds `lag` times the mean acceleration. The
 *  heading follows the horizontal velocity the short way round; slower than yaw_hold_speed it
 *  holds, at first `held_heading` or, without one, the vehicle's own. */
[[nodiscard]] HorizonReference sampleHorizon(const LocalPlannerInput& input,
                                             const LocalPlannerConfig& config,
                                             const core::Vehicle& vehicle,
                                             std::optional<double> held_heading);

}  // namespace slalom::local_planner::detail
