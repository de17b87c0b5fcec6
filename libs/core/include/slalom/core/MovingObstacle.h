// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstdint>

namespace slalom::core
{
/// A sphere that moves on in a straight line: what is known of something that is not part of the
/// static map.
struct MovingObstacle
{
  std::uint64_t id = 0;                           ///< the same for as long as it is tracked
  double t = 0.0;                                 ///< [s] log time of p_L
  Eigen::Vector3d p_L = Eigen::Vector3d::Zero();  ///< [m] centre, local frame
  Eigen::Vector3d v_L = Eigen::Vector3d::Zero();  ///< [m/s]
  double radius_m = 0.0;                          ///< [m]
  double sigma_p_m = 0.0;                         ///< [m] standard deviation of p_L, per axis
  double sigma_v_mps = 0.0;                       ///< [m/s] of v_L, per axis

  [[nodiscard]] Eigen::Vector3d at(double time) const { return p_L + (time - t) * v_L; }
};

}  // namespace slalom::core
