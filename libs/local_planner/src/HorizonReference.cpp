// SPDX-License-Identifier: BSD-3-Clause
#include "HorizonReference.h"

#include <algorithm>
#include <cmath>

#include "slalom/core/Math.h"

namespace slalom::local_planner::detail
{
namespace
{
Eigen::Vector3d velocityAt(const LocalPlannerInput& input, double rate, double parameter)
{
  if (parameter >= input.stop_at) return Eigen::Vector3d::Zero();
  return rate * input.reference->velocity(parameter);
}
}  // namespace

HorizonReference sampleHorizon(const LocalPlannerInput& input, const LocalPlannerConfig& config,
                               const core::Vehicle& vehicle, std::optional<double> held_heading)
{
  const int n = config.horizon;
  const double rate = std::clamp(input.rate, 0.0, 1.0);
  const double stride = rate * config.step_s;
  HorizonReference horizon{Eigen::Matrix4Xd(4, n + 1), Eigen::Matrix4Xd(4, n), 0.0};

  const double yaw = input.state.yaw();
  double heading = yaw + core::wrapAngle(held_heading.value_or(yaw) - yaw);
  for (int k = 0; k <= n; ++k)
  {
    const double parameter = input.progress + k * stride;
    const Eigen::Vector3d v = velocityAt(input, rate, parameter);
    if (v.head<2>().norm() >= std::max(config.yaw_hold_speed_mps, 1e-3))
    {
      // The short way is the vehicle's, not that of a heading it may never have reached.
      const double from = k == 0 ? yaw : heading;
      heading = from + core::wrapAngle(std::atan2(v.y(), v.x()) - from);
    }
    horizon.states.col(k) << input.reference->position(std::min(parameter, input.stop_at)), heading;
    if (k == n) break;
    horizon.inputs.col(k).head<3>() = velocityAt(input, rate, parameter + 0.5 * stride);
  }
  horizon.heading = horizon.states(3, 0);
  for (int k = 0; k < n; ++k)
    horizon.inputs(3, k) =
        std::clamp((horizon.states(3, k + 1) - horizon.states(3, k)) / config.step_s,
                   -vehicle.max_yaw_rate_radps, vehicle.max_yaw_rate_radps);
  return horizon;
}

}  // namespace slalom::local_planner::detail
