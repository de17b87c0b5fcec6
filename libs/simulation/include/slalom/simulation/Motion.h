// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>

namespace slalom::simulation
{
inline constexpr double kGravity = 9.80665;  ///< [m/s^2]

/// True state of the vehicle at one instant; frames as in docs/conventions.md.
struct MotionSample
{
  Eigen::Vector3d p_W = Eigen::Vector3d::Zero();             ///< [m]
  Eigen::Vector3d v_W = Eigen::Vector3d::Zero();             ///< [m/s]
  Eigen::Vector3d a_W = Eigen::Vector3d::Zero();             ///< [m/s^2] without gravity
  Eigen::Quaterniond q_WB = Eigen::Quaterniond::Identity();  ///< attitude
  Eigen::Vector3d w_B = Eigen::Vector3d::Zero();             ///< [rad/s]
};

/// Where the vehicle is at any time: all that a sensor model asks of a vehicle. Thread-safe.
class Motion
{
 public:
  virtual ~Motion() = default;
  [[nodiscard]] virtual Eigen::Isometry3d pose(double t) const = 0;  ///< T_WB
  [[nodiscard]] virtual MotionSample at(double t) const = 0;
};

/** Attitude of a multirotor that accelerates by `a_W` and heads towards `yaw`: its z axis is the
 * direction of thrust, a_W + g e_z, and its x axis has the heading `yaw` exactly.
 *  @param a_W acceleration, world frame [m/s^2], above free fall
 *  @param yaw [rad] */
[[nodiscard]] Eigen::Quaterniond hoverAttitude(const Eigen::Vector3d& a_W, double yaw);

}  // namespace slalom::simulation
