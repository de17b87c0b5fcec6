// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

#include "slalom/core/CommandLimits.h"
#include "slalom/core/Vehicle.h"
#include "slalom/core/VehicleState.h"
#include "slalom/safety/SafetyConfig.h"

namespace slalom::safety::detail
{
using core::braked, core::limited, core::trustedLast;

/// A late step does not make the command jump: change is never counted over more than this.
constexpr double kLongestTick = 0.2;  // [s]

/// One axis of the fence and of what moves along it.
struct FenceAxis
{
  double p, v;       ///< [m], [m/s] when the command takes effect, world frame
  double low, high;  ///< [m] the fence
  double braked;     ///< [m/s] the hardest brake
  double hold_s, lag_s, lag_reserve_s, deceleration;
};

/** The command nearest to `wanted` that leaves room to stop before the fence, if one between it
 * and the brake does, else the brake. Outside, only motion back in is left of it. */
[[nodiscard]] double insideFence(double wanted, const FenceAxis& axis);

}  // namespace slalom::safety::detail
