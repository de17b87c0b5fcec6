// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

namespace slalom::core
{
/// Angle wrapped to [-pi, pi) [rad].
[[nodiscard]] inline double wrapAngle(double angle)
{
  constexpr double kTwoPi = 2.0 * std::numbers::pi;
  const double wrapped = std::fmod(angle + std::numbers::pi, kTwoPi);
  return (wrapped < 0.0 ? wrapped + kTwoPi : wrapped) - std::numbers::pi;
}

/// Heading of the body x axis in the horizontal plane [rad], counter-clockwise from east.
[[nodiscard]] inline double yawOf(const Eigen::Quaterniond& q_WB)
{
  const Eigen::Vector3d x_axis_W = q_WB * Eigen::Vector3d::UnitX();
  return std::atan2(x_axis_W.y(), x_axis_W.x());
}

/// Rotation by `yaw` [rad] about the vertical.
[[nodiscard]] inline Eigen::Quaterniond fromYaw(double yaw)
{
  return Eigen::Quaterniond(Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()));
}

/// Matrix S with S b = a x b.
[[nodiscard]] inline Eigen::Matrix3d skew(const Eigen::Vector3d& a)
{
  Eigen::Matrix3d s;
  s << 0.0, -a.z(), a.y(), a.z(), 0.0, -a.x(), -a.y(), a.x(), 0.0;
  return s;
}

/// Exponential of the rotation vector `phi` [rad].
[[nodiscard]] inline Eigen::Quaterniond expSO3(const Eigen::Vector3d& phi)
{
  const double angle = phi.norm();
  // sin(x/2)/x, with its Taylor value near zero.
  const double k = angle < 1e-8 ? 0.5 - angle * angle / 48.0 : std::sin(0.5 * angle) / angle;
  return {std::cos(0.5 * angle), k * phi.x(), k * phi.y(), k * phi.z()};
}

}  // namespace slalom::core
