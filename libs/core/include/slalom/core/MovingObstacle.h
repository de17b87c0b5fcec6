// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstdint>

namespace slalom::core
{
/** What is known of something that moves on in a straight line and is not part of the static map:
 *  a sphere, or an upright capsule, which is all points within the radius of an upright axis. */
struct MovingObstacle
{
  std::uint64_t id = 0;                           ///< the same for as long as it is tracked
  double t = 0.0;                                 ///< [s] log time of p_L
  Eigen::Vector3d p_L = Eigen::Vector3d::Zero();  ///< [m] centre, local frame
  Eigen::Vector3d v_L = Eigen::Vector3d::Zero();  ///< [m/s]
  double radius_m = 0.0;                          ///< [m]
  double half_axis_m = 0.0;                       ///< [m] of the capsule's axis; 0: a sphere
  double sigma_p_m = 0.0;                         ///< [m] standard deviation of p_L, per axis
  double sigma_v_mps = 0.0;                       ///< [m/s] of v_L, per axis

  [[nodiscard]] Eigen::Vector3d at(double time) const { return p_L + (time - t) * v_L; }

  /// The point of the axis that is nearest to `point_L` at that time.
  [[nodiscard]] Eigen::Vector3d nearest(const Eigen::Vector3d& point_L, double time) const
  {
    Eigen::Vector3d centre = at(time);
    centre.z() += std::max(-half_axis_m, std::min(point_L.z() - centre.z(), half_axis_m));
    return centre;
  }

  /// [m] by which it may be elsewhere at that time, `sigmas` standard deviations, at most 0.5 m:
  /// what is less certain is seen again before.
  [[nodiscard]] double uncertainty(double time, double sigmas) const
  {
    constexpr double kMost = 0.5;
    return std::min(sigmas * std::hypot(sigma_p_m, (time - t) * sigma_v_mps), kMost);
  }
};

}  // namespace slalom::core
