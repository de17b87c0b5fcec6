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
