// SPDX-License-Identifier: BSD-3-Clause
#include "slalom/simulation/NavigationSensors.h"

#include <cmath>

namespace slalom::simulation
{
ImuModel::ImuModel(const ImuConfig& config, std::uint64_t seed)
    : config_(config),
      rng_(seed),
      accel_bias_(rng_.normal3(config.accel_bias_mps2)),
      gyro_bias_(rng_.normal3(config.gyro_bias_radps))
{
}

core::ImuSample ImuModel::sample(const Motion& motion, double t)
{
  const double step = std::sqrt(std::max(0.0, t - last_)), band = std::sqrt(config_.rate_hz);
  last_ = t;
  accel_bias_ += rng_.normal3(config_.accel_walk * step);
  gyro_bias_ += rng_.normal3(config_.gyro_walk * step);
  const MotionSample m = motion.at(t);
  core::ImuSample sample;
  sample.t = t;
  sample.f_B = m.q_WB.conjugate() * (m.a_W + Eigen::Vector3d(0.0, 0.0, kGravity)) + accel_bias_ +
               rng_.normal3(config_.accel_density * band);
  sample.w_B = m.w_B + gyro_bias_ + rng_.normal3(config_.gyro_density * band);
  return sample;
}

namespace
{
/// East and north as given, up doubled.
Eigen::Vector3d slowNoise(core::Rng& rng, double sigma)
{
  return rng.normal3(sigma).cwiseProduct(Eigen::Vector3d(1.0, 1.0, 2.0));
}
}  // namespace

GpsModel::GpsModel(const GpsConfig& config, std::uint64_t seed)
    : config_(config), rng_(seed), bias_(slowNoise(rng_, config.bias_sigma_m))
{
}

mrpt_io::GpsReading GpsModel::reading(const Motion& motion, double t)
{
  // Exact discretisation of the Gauss-Markov process.
  const double passed = std::max(0.0, t - last_);
  const double keep = std::exp(-passed / config_.bias_time_s);
  last_ = t;
  bias_ = keep * bias_ + slowNoise(rng_, config_.bias_sigma_m * std::sqrt(1.0 - keep * keep));
  if (config_.bias_walk > 0.0) walked_ += slowNoise(rng_, config_.bias_walk * std::sqrt(passed));
  const MotionSample m = motion.at(t - config_.delay_s);
  const Eigen::Vector3d white = rng_.normal3(1.0).cwiseProduct(
      Eigen::Vector3d(config_.sigma_m, config_.sigma_m, config_.sigma_up_m));
  mrpt_io::GpsReading reading;
  reading.p_W = m.p_W + m.q_WB * config_.lever_m + bias_ + walked_ + white;
  if (t >= config_.jump_time_s) reading.p_W += config_.jump_m;
  reading.v_W =
      m.v_W + m.q_WB * m.w_B.cross(config_.lever_m) + rng_.normal3(config_.velocity_sigma_mps);
  reading.sigma = std::hypot(config_.sigma_m, config_.bias_sigma_m);
  reading.lever_B = config_.lever_m;
  return reading;
}

VelocityModel::VelocityModel(const VelocityConfig& config, std::uint64_t seed)
    : config_(config), rng_(seed)
{
}

Eigen::Vector3d VelocityModel::sample(const Motion& motion, double t)
{
  return motion.at(t).v_W + rng_.normal3(config_.sigma_mps);
}

}  // namespace slalom::simulation
