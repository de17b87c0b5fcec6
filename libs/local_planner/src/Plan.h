// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

#include "HorizonReference.h"
#include "slalom/core/Vehicle.h"
#include "slalom/core/VelocityResponse.h"

namespace slalom::local_planner::detail
{
/// A predicted motion: held commands and the states they lead through.
struct Plan
{
  double t = 0.0;               ///< [s] log time of stage 0
  Eigen::Matrix3Xd positions;   ///< 3x(N+1) [m]
  Eigen::Matrix3Xd velocities;  ///< 3x(N+1) [m/s]
  Eigen::VectorXd yaw;          ///< N+1 [rad], continuous
  Eigen::Matrix4Xd inputs;      ///< 4xN: velocity [m/s] in world axes, yaw rate [rad/s]

  [[nodiscard]] core::VelocityCommand command() const
  {
    return {inputs.col(0).head<3>(), inputs(3, 0)};
  }
};

/// How the vehicle answers to commands that are held for a step.
struct Model
{
  core::Vehicle vehicle;
  double step;                                            ///< [s]
  Eigen::Vector3d disturbance = Eigen::Vector3d::Zero();  ///< [m/s^2]

  /// A disturbance acts like a command that is off by this [m/s].
  [[nodiscard]] Eigen::Vector3d offset() const { return vehicle.velocity_lag_s * disturbance; }
  [[nodiscard]] core::Motion after(const core::Motion& from, const Eigen::Vector4d& input) const
  {
    return core::held(from, {input.head<3>() + offset(), input[3]}, step, vehicle);
  }
};

[[nodiscard]] core::Motion motionOf(const core::VehicleState& state);

/// The inputs of `plan` as seen `elapsed` seconds later; the last one is held beyond the end.
[[nodiscard]] Eigen::Matrix4Xd shiftedInputs(const Plan& plan, double elapsed, double step);

/// States from `start` under `inputs`.
[[nodiscard]] Plan rollOut(double t, const core::Motion& start, Eigen::Matrix4Xd inputs,
                           const Model& model);

/** Follows the reference without optimising: its commands, and half a second to make good what the
 * vehicle is off, within the limits of speed and acceleration. */
[[nodiscard]] Plan pursue(double t, const core::Motion& start, const Eigen::Vector4d& last_input,
                          const HorizonReference& reference, const Model& model);

}  // namespace slalom::local_planner::detail
