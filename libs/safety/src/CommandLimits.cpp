// SPDX-License-Identifier: BSD-3-Clause
#include "CommandLimits.h"

#include <algorithm>
#include <cmath>

#include "slalom/core/VelocityResponse.h"

namespace slalom::safety::detail
{
namespace
{
// Below the upper end of the fence; the lower one is its mirror image.
double belowFence(double wanted, const FenceAxis& axis)
{
  constexpr double kRoom = 1e-3;  // [m] of the fence that is left to rounding
  if (axis.p > axis.high) return std::min(wanted, std::max(axis.braked, 0.0));
  const auto response = core::VelocityResponse::over(axis.hold_s, axis.lag_s);
  // The farthest point of the axis if it is braked after the hold; grows with u.
  const auto farthest = [&](double u)
  {
    const double v = response.v_v * axis.v + response.v_u * u, on = std::max(u, 0.0);
    return axis.p + response.p_v * axis.v + response.p_u * u + axis.lag_s * v +
           axis.lag_reserve_s * std::max(axis.v, v) + 0.5 * on * on / axis.deceleration;
  };
  double low = std::min(axis.braked, wanted), high = wanted;
  if (farthest(high) <= axis.high - kRoom) return wanted;
  if (low == high || farthest(low) > axis.high - kRoom) return low;
  for (int halving = 0; halving < 40; ++halving)
  {
    const double middle = 0.5 * (low + high);
    (farthest(middle) <= axis.high - kRoom ? low : high) = middle;
  }
  return low;
}
}  // namespace

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

Eigen::Vector3d limited(const Eigen::Vector3d& wanted, const Eigen::Vector3d& last, double change,
                        const core::Vehicle& vehicle)
{
  const double limit = vehicle.max_speed_mps;
  return wanted.cwiseMax((last.array() - change).matrix())
      .cwiseMin((last.array() + change).matrix())
      .cwiseMax(-limit)
      .cwiseMin(limit);
}

Eigen::Vector3d braked(const Eigen::Vector3d& v, double change)
{
  return v.cwiseMin((v.array() - change).max(0.0).matrix())
      .cwiseMax((v.array() + change).min(0.0).matrix());
}

double insideFence(double wanted, const FenceAxis& axis)
{
  const double below = belowFence(wanted, axis);
  FenceAxis mirrored = axis;
  mirrored.p = -axis.p;
  mirrored.v = -axis.v;
  mirrored.low = -axis.high;
  mirrored.high = -axis.low;
  mirrored.braked = -axis.braked;
  return -belowFence(-below, mirrored);
}

}  // namespace slalom::safety::detail
