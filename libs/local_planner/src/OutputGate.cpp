// SPDX-License-Identifier: BSD-3-Clause
#include "OutputGate.h"

#include <algorithm>
#include <cmath>

namespace slalom::local_planner::detail
{
core::VelocityCommand trustedLast(const core::VelocityCommand& last,
                                  const Eigen::Vector3d& measured_v_W, const core::Vehicle& vehicle)
{
  core::VelocityCommand trusted;
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

core::VelocityCommand gate(const core::VelocityCommand& wanted, const core::VelocityCommand& last,
                           double dt, const core::Vehicle& vehicle)
{
  if (!wanted.v_W.allFinite() || !std::isfinite(wanted.yaw_rate)) return brake(last, dt, vehicle);
  const double change = vehicle.max_acceleration_mps2 * dt;
  core::VelocityCommand passed;
  for (int i = 0; i < 3; ++i)
  {
    const double v = std::clamp(wanted.v_W[i], last.v_W[i] - change, last.v_W[i] + change);
    passed.v_W[i] = std::clamp(v, -vehicle.max_speed_mps, vehicle.max_speed_mps);
  }
  passed.yaw_rate =
      std::clamp(wanted.yaw_rate, -vehicle.max_yaw_rate_radps, vehicle.max_yaw_rate_radps);
  return passed;
}

core::VelocityCommand brake(const core::VelocityCommand& last, double dt,
                            const core::Vehicle& vehicle)
{
  const double change = vehicle.max_acceleration_mps2 * dt;
  core::VelocityCommand braked;
  for (int i = 0; i < 3; ++i)
    braked.v_W[i] = std::copysign(std::max(std::abs(last.v_W[i]) - change, 0.0), last.v_W[i]);
  return braked;
}

}  // namespace slalom::local_planner::detail
