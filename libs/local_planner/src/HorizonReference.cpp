// SPDX-License-Identifier: BSD-3-Clause
#include "HorizonReference.h"

#include <algorithm>
#include <cmath>

#include "slalom/core/Math.h"

namespace slalom::local_planner::detail
{
namespace
{
Eigen::Vector3d velocityAt(const LocalPlannerInput& input, double parameter)
{
  if (parameter >= input.law->to()) return Eigen::Vector3d::Zero();
  return input.law->pace(parameter) * input.reference->velocity(parameter);
}

Eigen::Vector3d accelerationAt(const LocalPlannerInput& input, double parameter)
{
  if (parameter >= input.law->to()) return Eigen::Vector3d::Zero();
  const double pace = input.law->pace(parameter);
  return pace * pace * input.reference->acceleration(parameter) +
         input.law->paceChange(parameter) * input.reference->velocity(parameter);
}

Eigen::Vector3d within(const Eigen::Vector3d& value, double limit)
{
  return value.cwiseMax(-limit).cwiseMin(limit);
}
}  // namespace

HorizonReference sampleHorizon(const LocalPlannerInput& input, const LocalPlannerConfig& config,
                               const core::Vehicle& vehicle, std::optional<double> held_heading)
{
  const int n = config.horizon;
  HorizonReference horizon;
  for (auto* points : {&horizon.positions, &horizon.velocities}) points->resize(3, n + 1);
  horizon.commands.resize(3, n);
  horizon.yaw.resize(n + 1);
  horizon.yaw_rates.resize(n);

  const double yaw = input.state.yaw();
  double heading = yaw + core::wrapAngle(held_heading.value_or(yaw) - yaw);
  double parameter = std::min(input.progress, input.law->to());
  horizon.acceleration = within(accelerationAt(input, parameter), vehicle.max_acceleration_mps2);
  for (int k = 0; k <= n; ++k)
  {
    const Eigen::Vector3d v = velocityAt(input, parameter);
    if (v.head<2>().norm() >= std::max(config.yaw_hold_speed_mps, 1e-3))
    {
      // The short way is the vehicle's, not that of a heading it may never have reached.
      const double from = k == 0 ? yaw : heading;
      heading = from + core::wrapAngle(std::atan2(v.y(), v.x()) - from);
    }
    horizon.positions.col(k) = input.reference->position(parameter);
    horizon.velocities.col(k) = v;
    horizon.yaw[k] = heading;
    if (k > 0)
    {
      const Eigen::Vector3d gain = (v - horizon.velocities.col(k - 1)) / config.step_s;
      horizon.commands.col(k - 1) +=
          vehicle.velocity_lag_s *
          (within(gain, vehicle.max_acceleration_mps2) - input.disturbance_W);
      horizon.yaw_rates[k - 1] =
          std::clamp((heading - horizon.yaw[k - 1]) / config.step_s, -vehicle.max_yaw_rate_radps,
                     vehicle.max_yaw_rate_radps);
    }
    if (k == n) break;
    const double middle = input.law->advance(parameter, 0.5 * config.step_s);
    horizon.commands.col(k) = velocityAt(input, middle);
    parameter = input.law->advance(middle, 0.5 * config.step_s);
  }
  horizon.heading = horizon.yaw[0];
  return horizon;
}

}  // namespace slalom::local_planner::detail
