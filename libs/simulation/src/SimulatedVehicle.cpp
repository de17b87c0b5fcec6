// SPDX-License-Identifier: BSD-3-Clause
#include "slalom/simulation/SimulatedVehicle.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "slalom/core/Math.h"

namespace slalom::simulation
{
SimulatedVehicle::SimulatedVehicle(const AirframeConfig& config, const Eigen::Vector3d& p_W,
                                   double yaw)
    : config_(config)
{
  if (!p_W.allFinite() || !std::isfinite(yaw))
    throw std::invalid_argument("SimulatedVehicle: the start is not finite");
  motion_.p = p_W;
  motion_.yaw = yaw;
  sample_.p_W = p_W;
  sample_.q_WB = hoverAttitude(Eigen::Vector3d::Zero(), yaw);
}

void SimulatedVehicle::command(const core::VelocityCommand& command)
{
  if (!command.v_W.allFinite() || !std::isfinite(command.yaw_rate))
    throw std::invalid_argument("SimulatedVehicle: the command is not finite");
  waiting_.push_back({t_ + config_.command_delay_s, command});
}

/// Velocity that the vehicle settles at: the command, and what the wind adds to it.
Eigen::Vector3d SimulatedVehicle::wanted() const
{
  return obeyed_.v_W + config_.velocity_lag_s * config_.drag_per_s * config_.wind_mps;
}

void SimulatedVehicle::obey(double dt)
{
  const core::Motion before = motion_;
  // The error keeps its direction: it shrinks at the acceleration limit, then exponentially.
  const Eigen::Vector3d missing = wanted() - before.v;
  const double limit = config_.max_acceleration_mps2, size = missing.norm();
  const double at_limit = std::clamp(size / limit - config_.velocity_lag_s, 0.0, dt);
  Eigen::Vector3d p = before.p, v = before.v;
  if (at_limit > 0.0)
  {
    const Eigen::Vector3d a = missing * (limit / size);
    p += at_limit * v + 0.5 * at_limit * at_limit * a;
    v += at_limit * a;
  }
  const auto move = core::VelocityResponse::over(dt - at_limit, config_.velocity_lag_s);
  const auto turn = core::VelocityResponse::over(dt, config_.yaw_rate_lag_s);
  const double yaw_rate =
      std::clamp(obeyed_.yaw_rate, -config_.max_yaw_rate_radps, config_.max_yaw_rate_radps);
  motion_ = {p + move.p_v * v + move.p_u * wanted(), move.v_v * v + move.v_u * wanted(),
             before.yaw + turn.p_v * before.yaw_rate + turn.p_u * yaw_rate,
             turn.v_v * before.yaw_rate + turn.v_u * yaw_rate};
  t_ += dt;
}

void SimulatedVehicle::advance(double dt)
{
  constexpr double kSameTime = 1e-9;  // [s]
  if (!(dt > 0.0)) return;
  const double end = t_ + dt;
  const Eigen::Vector3d v_before = motion_.v;
  for (; !waiting_.empty() && waiting_.front().t <= end - kSameTime; waiting_.pop_front())
  {
    obey(std::max(0.0, waiting_.front().t - t_));
    obeyed_ = waiting_.front().command;
  }
  obey(end - t_);
  t_ = end;

  // Means of the step, as an IMU that integrates between its samples gives them: they add up to the
  // motion exactly, however the commands step.
  const Eigen::Vector3d a_W = (motion_.v - v_before) / dt;
  const double follows =
      config_.attitude_lag_s > 0.0 ? -std::expm1(-dt / config_.attitude_lag_s) : 1.0;
  tilt_W_ += follows * (a_W - tilt_W_);
  const Eigen::Quaterniond q_WB = hoverAttitude(tilt_W_, motion_.yaw);
  const Eigen::AngleAxisd turned(sample_.q_WB.conjugate() * q_WB);
  sample_ = {motion_.p, motion_.v, a_W, q_WB, turned.axis() * core::wrapAngle(turned.angle()) / dt};
}

}  // namespace slalom::simulation
