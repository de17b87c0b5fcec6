// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "slalom/core/Vehicle.h"
#include "slalom/core/VehicleState.h"

namespace slalom::core
{
/// The command that counts as the last one: `last` inside the speed limits; where it is not finite
/// the measured velocity, and failing that, rest.
[[nodiscard]] inline VelocityCommand trustedLast(const VelocityCommand& last,
                                                 const Eigen::Vector3d& measured_v_W,
                                                 const Vehicle& vehicle)
{
  VelocityCommand trusted;
  const double limit = vehicle.max_speed_mps;
  for (int i = 0; i < 3; ++i)
  {
    const double v = std::isfinite(last.v_W[i]) ? last.v_W[i] : measured_v_W[i];
    trusted.v_W[i] = std::isfinite(v) ? std::clamp(v, -limit, limit) : 0.0;
  }
  if (std::isfinite(last.yaw_rate))
    trusted.yaw_rate =
        std::clamp(last.yaw_rate, -vehicle.max_yaw_rate_radps, vehicle.max_yaw_rate_radps);
  return trusted;
}

/// The velocity nearest to `wanted` inside the speed limit that is at most `change` per axis from
/// `last`. @param wanted finite @param last inside the speed limit
[[nodiscard]] inline Eigen::Vector3d limited(const Eigen::Vector3d& wanted,
                                             const Eigen::Vector3d& last, double change,
                                             const Vehicle& vehicle)
{
  const double limit = vehicle.max_speed_mps;
  return wanted.cwiseMax((last.array() - change).matrix())
      .cwiseMin((last.array() + change).matrix())
      .cwiseMax(-limit)
      .cwiseMin(limit);
}

/// `v` brought towards rest by `change` per axis.
[[nodiscard]] inline Eigen::Vector3d braked(const Eigen::Vector3d& v, double change)
{
  return v.cwiseMin((v.array() - change).max(0.0).matrix())
      .cwiseMax((v.array() + change).min(0.0).matrix());
}

}  // namespace slalom::core
