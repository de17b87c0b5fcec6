// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>

#include "slalom/core/Math.h"

namespace slalom::core
{
/** What the estimator knows of the vehicle at one instant.
 *
 *  Frames (docs/conventions.md): W is the world, ENU with z up; B is the body, forward-left-up. L
 * is the smooth local frame in which maps and plans live: its axes are those of W, its origin
 * drifts slowly, and it never jumps, so a GPS correction moves p_W but no obstacle relative to the
 * vehicle. */
struct VehicleState
{
  double t = 0.0;  ///< [s] log time: since the start of the recording
  Eigen::Vector3d p_L = Eigen::Vector3d::Zero();             ///< [m] position, local frame
  Eigen::Vector3d p_W = Eigen::Vector3d::Zero();             ///< [m] position, world frame
  Eigen::Quaterniond q_WB = Eigen::Quaterniond::Identity();  ///< attitude
  Eigen::Vector3d v_W = Eigen::Vector3d::Zero();             ///< [m/s] velocity, world axes
  Eigen::Vector3d w_B = Eigen::Vector3d::Zero();             ///< [rad/s] angular rate, body axes
  /// Covariance of the error [position_W (m), velocity_W (m/s), rotation (rad, world axes)].
  Eigen::Matrix<double, 9, 9> covariance = Eigen::Matrix<double, 9, 9>::Zero();

  [[nodiscard]] double yaw() const { return yawOf(q_WB); }
};

/// A pose with its time; the row of a TUM file.
struct TimedPose
{
  double t = 0.0;  ///< [s] log time
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  Eigen::Quaterniond orientation = Eigen::Quaterniond::Identity();
};

/// What leaves Slalom: velocity in world axes and yaw rate. The default is "stand still".
struct VelocityCommand
{
  Eigen::Vector3d v_W = Eigen::Vector3d::Zero();  ///< [m/s]
  double yaw_rate = 0.0;                          ///< [rad/s] counter-clockwise seen from above
};

}  // namespace slalom::core
