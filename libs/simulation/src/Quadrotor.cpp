// SPDX-License-Identifier: BSD-3-Clause
#include "slalom/simulation/Quadrotor.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "slalom/core/Math.h"
#include "slalom/simulation/SimulatedVehicle.h"

namespace slalom::simulation
{
namespace
{
const Eigen::Vector3d kWeight(0.0, 0.0, kGravity);
constexpr double kYawGain = 4.0;  // [1/s]

/// Share of the way that a first order goes in one inner step.
double share(double lag)
{
  return lag > 0.0 ? -std::expm1(-Quadrotor::kStep / lag) : 1.0;
}

Eigen::Vector3d shortened(const Eigen::Vector3d& v, double limit)
{
  const double size = v.norm();
  return size > limit ? Eigen::Vector3d(v * (limit / size)) : v;
}

Eigen::Quaterniond turnedBy(const Eigen::Vector3d& rotation)
{
  return Eigen::Quaterniond(Eigen::AngleAxisd(rotation.norm(), rotation.stableNormalized()));
}

double headingOf(const Eigen::Quaterniond& q_WB)
{
  const Eigen::Vector3d x = q_WB * Eigen::Vector3d::UnitX();
  return std::atan2(x.y(), x.x());
}
}  // namespace

Quadrotor::Quadrotor(const AirframeConfig& config, const Eigen::Vector3d& p_W, double yaw,
                     std::uint64_t seed)
    : config_(config),
      rng_(seed),
      p_(p_W),
      v_(Eigen::Vector3d::Zero()),
      a_(Eigen::Vector3d::Zero()),
      integral_(shortened(-config.drag_per_s * config.wind_mps, config.max_integral_mps2)),
      gust_(Eigen::Vector3d::Zero()),
      w_B_(Eigen::Vector3d::Zero()),
      heading_(yaw)
{
  if (!p_W.allFinite() || !std::isfinite(yaw))
    throw std::invalid_argument("Quadrotor: the start is not finite");
  const Eigen::Vector3d trim = withinLimits(integral_ + kWeight);
  thrust_ = trim.norm();
  q_WB_ = hoverAttitude(trim - kWeight, yaw);
  sample_.p_W = p_;
  sample_.q_WB = q_WB_;
}

void Quadrotor::command(const core::VelocityCommand& command)
{
  if (!command.v_W.allFinite() || !std::isfinite(command.yaw_rate))
    throw std::invalid_argument("Quadrotor: the command is not finite");
  waiting_.push_back({time() + config_.command_delay_s, command});
}

void Quadrotor::blow()
{
  if (config_.gust_mps <= 0.0) return;
  const double keep = 1.0 - share(config_.gust_time_s);
  const Eigen::Vector3d sigma = config_.gust_mps * Eigen::Vector3d(1.0, 1.0, 0.5);
  gust_ = keep * gust_ + rng_.normal3(std::sqrt(1.0 - keep * keep)).cwiseProduct(sigma);
}

/// A thrust that the rotors and the tilt limit permit: the vertical part as far as it can be had,
/// the horizontal part from what is left.
Eigen::Vector3d Quadrotor::withinLimits(const Eigen::Vector3d& thrust) const
{
  const double least = config_.min_thrust_g * kGravity, most = config_.max_thrust_g * kGravity;
  const double up = std::clamp(thrust.z(), std::max(least, 1e-3 * kGravity), most);
  const double room = std::min(up * std::tan(config_.max_tilt_deg * std::numbers::pi / 180.0),
                               std::sqrt(std::max(0.0, most * most - up * up)));
  const Eigen::Vector3d across(thrust.x(), thrust.y(), 0.0);
  return shortened(across, room) + Eigen::Vector3d(0.0, 0.0, up);
}

Eigen::Vector3d Quadrotor::wantedThrust()
{
  const Eigen::Vector3d error = obeyed_.v_W - v_;
  const double gain = (1.0 + config_.velocity_damping) / config_.velocity_lag_s;
  const Eigen::Vector3d wanted = gain * error - config_.velocity_damping * a_ + integral_;
  const Eigen::Vector3d limited = shortened(wanted, config_.max_acceleration_mps2);
  const Eigen::Vector3d thrust = withinLimits(limited + kWeight);
  constexpr double kFree = 1e-9;  // [m/s^2]
  if ((thrust - kWeight - wanted).norm() < kFree)
    integral_ =
        shortened(integral_ + kStep * config_.velocity_integral * error, config_.max_integral_mps2);
  return thrust;
}

/// Angular acceleration of the attitude loops, and the turn of one step.
void Quadrotor::turn(const Eigen::Vector3d& thrust_W)
{
  const double rate =
      std::clamp(obeyed_.yaw_rate, -config_.max_yaw_rate_radps, config_.max_yaw_rate_radps);
  heading_rate_ += share(config_.yaw_rate_lag_s) * (rate - heading_rate_);
  heading_ += kStep * heading_rate_;
  const double yaw_rate = heading_rate_ + kYawGain * core::wrapAngle(heading_ - headingOf(q_WB_));
  const Eigen::Vector3d yawing_B = q_WB_.conjugate() * Eigen::Vector3d(0.0, 0.0, yaw_rate);

  // The shortest turn of the thrust axis; it has no component along that axis.
  const Eigen::Vector3d towards_B = q_WB_.conjugate() * thrust_W.normalized();
  const Eigen::Vector3d axis = Eigen::Vector3d::UnitZ().cross(towards_B);
  const double angle = std::atan2(axis.norm(), towards_B.z());
  const Eigen::Vector3d error = angle * axis.stableNormalized();
  const double quick = 2.0 / std::max(config_.attitude_lag_s, 20.0 * kStep);  // [1/s]
  for (int i = 0; i < 2; ++i)
  {
    const double rate_of = w_B_[i] - yawing_B[i];
    w_B_[i] += kStep * quick * (quick * error[i] - 2.0 * rate_of);
    w_B_[i] = std::clamp(w_B_[i], -config_.max_body_rate_radps, config_.max_body_rate_radps);
  }
  w_B_.z() = yawing_B.z();
  q_WB_ = (q_WB_ * turnedBy(kStep * w_B_)).normalized();
}

void Quadrotor::step()
{
  constexpr double kSameTime = 1e-9;  // [s]
  for (; !waiting_.empty() && waiting_.front().t <= time() + kSameTime; waiting_.pop_front())
    obeyed_ = waiting_.front().command;
  blow();
  const Eigen::Vector3d wanted = wantedThrust();
  turn(wanted);
  const Eigen::Vector3d axis = q_WB_ * Eigen::Vector3d::UnitZ();
  const double along = std::clamp(wanted.dot(axis), config_.min_thrust_g * kGravity,
                                  config_.max_thrust_g * kGravity);
  thrust_ += share(config_.rotor_lag_s) * (along - thrust_);
  a_ = thrust_ * axis - kWeight - config_.drag_per_s * (v_ - config_.wind_mps - gust_);
  p_ += kStep * v_ + 0.5 * kStep * kStep * a_;
  v_ += kStep * a_;
  ++steps_;
}

void Quadrotor::advance(double dt)
{
  if (!(dt > 0.0)) return;
  behind_ += dt;
  const auto steps = static_cast<int>(std::floor(behind_ / kStep + 1e-6));
  if (steps <= 0) return;
  behind_ -= kStep * steps;
  const Eigen::Vector3d v_before = v_;
  for (int k = 0; k < steps; ++k) step();
  const double passed = kStep * steps;
  const Eigen::AngleAxisd turned(sample_.q_WB.conjugate() * q_WB_);
  sample_ = {p_, v_, (v_ - v_before) / passed, q_WB_,
             turned.axis() * core::wrapAngle(turned.angle()) / passed};
}

std::unique_ptr<VehicleModel> makeVehicle(const AirframeConfig& config, const Eigen::Vector3d& p_W,
                                          double yaw, std::uint64_t seed)
{
  if (config.model == AirframeModel::Quadrotor)
    return std::make_unique<Quadrotor>(config, p_W, yaw, seed);
  if (config.gust_mps > 0.0)
    throw std::invalid_argument("[airframe] gust_mps: only model = quadrotor feels gusts");
  return std::make_unique<SimulatedVehicle>(config, p_W, yaw);
}

}  // namespace slalom::simulation
