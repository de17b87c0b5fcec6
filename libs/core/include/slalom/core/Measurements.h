// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <string>
#include <variant>

#include "slalom/core/PointCloud.h"

namespace slalom::core
{
/// Specific force and angular rate in body axes (FLU), as an ideal IMU at the body origin would
/// report them.
struct ImuSample
{
  double t = 0.0;                                 ///< [s] log time
  Eigen::Vector3d f_B = Eigen::Vector3d::Zero();  ///< [m/s^2] specific force; +9.81 on z at rest
  Eigen::Vector3d w_B = Eigen::Vector3d::Zero();  ///< [rad/s]
};

/// Position fix of an antenna in the world frame (ENU).
struct PositionFix
{
  double t = 0.0;                                     ///< [s] log time of validity, not of arrival
  Eigen::Vector3d p_W = Eigen::Vector3d::Zero();      ///< [m]
  Eigen::Vector3d sigma = Eigen::Vector3d::Ones();    ///< [m] standard deviation per axis
  Eigen::Vector3d lever_B = Eigen::Vector3d::Zero();  ///< [m] antenna in the body frame
  std::string source;  ///< sensor label; each receiver is gated on its own
};

/// Velocity of the body origin, in world or body axes.
struct VelocityFix
{
  double t = 0.0;
  Eigen::Vector3d v = Eigen::Vector3d::Zero();             ///< [m/s]
  Eigen::Vector3d sigma = Eigen::Vector3d::Constant(0.1);  ///< [m/s]; infinite: axis not measured
  bool in_body = false;
  std::string source;
};

/// Heading from a compass, a second antenna or a pose source.
struct YawFix
{
  double t = 0.0;
  double yaw = 0.0;    ///< [rad] ENU, counter-clockwise from east
  double sigma = 0.1;  ///< [rad]
  std::string source;
};

/// Pose of the body from an external source (motion capture, SLAM, simulator truth).
struct PoseFix
{
  double t = 0.0;
  Eigen::Isometry3d T_WB = Eigen::Isometry3d::Identity();
  double sigma_position = 0.02;  ///< [m]
  double sigma_rotation = 0.01;  ///< [rad]
  std::string source;
};

/// Everything a recording can say, in Slalom's own words.
using Measurement = std::variant<ImuSample, PositionFix, VelocityFix, YawFix, PoseFix, RangeScan>;

[[nodiscard]] inline double timeOf(const Measurement& measurement)
{
  return std::visit([](const auto& m) { return m.t; }, measurement);
}

}  // namespace slalom::core
