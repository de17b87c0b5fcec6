// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

#include "slalom/core/Vehicle.h"
#include "slalom/core/VehicleState.h"
#include "slalom/safety/SafetyConfig.h"

namespace slalom::safety::detail
{
/// A late step does not make the command jump: change is never counted over more than this.
constexpr double kLongestTick = 0.2;  // [s]

/// The command that counts as the last one: `last` inside the speed limits; where it is not finite
/// the measured velocity, and failing that, rest.
[[nodiscard]] core::VelocityCommand trustedLast(const core::VelocityCommand& last,
                                                const Eigen::Vector3d& measured_v_W,
                                                const core::Vehicle& vehicle);

/// The velocity nearest to `wanted` inside the speed limit that is at most `change` per axis from
/// `last`. @param wanted finite @param last inside the speed limit
[[nodiscard]] Eigen::Vector3d limited(const Eigen::Vector3d& wanted, const Eigen::Vector3d& last,
                                      double change, const core::Vehicle& vehicle);

/// `v` brought towards rest by `change` per axis.
[[nodiscard]] Eigen::Vector3d braked(const Eigen::Vector3d& v, double change);

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
