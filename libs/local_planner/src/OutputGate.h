// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

#include "slalom/core/Vehicle.h"
#include "slalom/core/VehicleState.h"

namespace slalom::local_planner::detail
{
/// The command that counts as the last one: `last` inside the speed limits; where it is not finite
/// the measured velocity, and failing that, rest.
[[nodiscard]] core::VelocityCommand trustedLast(const core::VelocityCommand& last,
                                                const Eigen::Vector3d& measured_v_W,
                                                const core::Vehicle& vehicle);

/** Nothing leaves the planner but through this gate: finite, inside the limits of speed (per axis)
 * and yaw rate, and not farther from `last` than max_acceleration * dt per axis.
 *  @param last from trustedLast() */
[[nodiscard]] core::VelocityCommand gate(const core::VelocityCommand& wanted,
                                         const core::VelocityCommand& last, double dt,
                                         const core::Vehicle& vehicle);

/// Towards rest as fast as the acceleration limit permits.
[[nodiscard]] core::VelocityCommand brake(const core::VelocityCommand& last, double dt,
                                          const core::Vehicle& vehicle);

}  // namespace slalom::local_planner::detail
