// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cmath>

#include "slalom/core/Vehicle.h"
#include "slalom/core/VehicleState.h"

namespace slalom::core
{
/** How position and velocity of an axis follow a command u that is held for some time:
 *  v' = (u - v) / lag, p' = v, solved without error:
 *
 *    p+ = p + p_v v + p_u u,   v+ = v_v v + v_u u
 *
 *  Without a lag the velocity is the command: p_v = v_v = 0. */
struct VelocityResponse
{
  double p_v = 0.0, p_u = 0.0, v_v = 0.0, v_u = 1.0;

  /// @param dt [s] >= 0; @param lag [s] >= 0
  [[nodiscard]] static VelocityResponse over(double dt, double lag)
  {
    if (lag <= 0.0) return {0.0, dt, 0.0, 1.0};
    const double gone = -std::expm1(-dt / lag);
    return {lag * gone, dt - lag * gone, 1.0 - gone, gone};
  }
};

/// What a velocity command acts on.
struct Motion
{
  Eigen::Vector3d p = Eigen::Vector3d::Zero();  ///< [m]
  Eigen::Vector3d v = Eigen::Vector3d::Zero();  ///< [m/s]
  double yaw = 0.0;                             ///< [rad], continuous
  double yaw_rate = 0.0;                        ///< [rad/s]
};

/// The motion after `command` was held for dt seconds by a vehicle with these lags.
[[nodiscard]] inline Motion held(const Motion& from, const VelocityCommand& command, double dt,
                                 const Vehicle& vehicle)
{
  const auto move = VelocityResponse::over(dt, vehicle.velocity_lag_s);
  const auto turn = VelocityResponse::over(dt, vehicle.yaw_rate_lag_s);
  return {from.p + move.p_v * from.v + move.p_u * command.v_W,
          move.v_v * from.v + move.v_u * command.v_W,
          from.yaw + turn.p_v * from.yaw_rate + turn.p_u * command.yaw_rate,
          turn.v_v * from.yaw_rate + turn.v_u * command.yaw_rate};
}

}  // namespace slalom::core
