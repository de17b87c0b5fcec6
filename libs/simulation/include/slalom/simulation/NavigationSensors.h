// SPDX-License-Identifier: BSD-3-Clause
/** Seeded models of what tells a vehicle where it is: IMU, GPS, velocity. Each has its own random
 * stream; samples must be asked for in order of time. */
#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "slalom/core/Fields.h"
#include "slalom/core/Measurements.h"
#include "slalom/core/Rng.h"
#include "slalom/mrpt_io/Encoders.h"
#include "slalom/simulation/Motion.h"

namespace slalom::simulation
{
/// Silence of a sensor with outage_start_s and outage_s in its config.
template <class Config>
[[nodiscard]] bool isOut(const Config& config, double t)
{
  return t >= config.outage_start_s && t < config.outage_start_s + config.outage_s;
}

/// INI section [imu]. Defaults: a good MEMS unit on a damped mount.
struct ImuConfig
{
  double rate_hz = 200.0;         ///< [1/s]
  double accel_density = 2e-3;    ///< [m/s^2/sqrt(Hz)] white noise
  double gyro_density = 2e-4;     ///< [rad/s/sqrt(Hz)] white noise
  double accel_bias_mps2 = 0.05;  ///< [m/s^2] sigma of the bias at switch-on
  double gyro_bias_radps = 3e-3;  ///< [rad/s] sigma of the bias at switch-on
  double accel_walk = 5e-4;       ///< [m/s^2/sqrt(s)] random walk of the bias
  double gyro_walk = 2e-5;        ///< [rad/s/sqrt(s)] random walk of the bias

  template <class Self, class Visit>
  static void fields(Self& c, Visit&& v)
  {
    using core::Range;
    v("rate_hz", c.rate_hz, Range{10.0, 2000.0}, "samples per second");
    v("accel_density", c.accel_density, Range{0.0, 1.0}, "accelerometer noise, m/s^2/sqrt(Hz)");
    v("gyro_density", c.gyro_density, Range{0.0, 1.0}, "gyroscope noise, rad/s/sqrt(Hz)");
    v("accel_bias_mps2", c.accel_bias_mps2, Range{0.0, 5.0}, "sigma of the first bias");
    v("gyro_bias_radps", c.gyro_bias_radps, Range{0.0, 1.0}, "sigma of the first bias");
    v("accel_walk", c.accel_walk, Range{0.0, 1.0}, "walk of the bias, m/s^2/sqrt(s)");
    v("gyro_walk", c.gyro_walk, Range{0.0, 1.0}, "walk of the bias, rad/s/sqrt(s)");
  }
};

/// Specific force and angular rate with white noise and a bias that walks. At the body origin.
class ImuModel
{
 public:
  ImuModel(const ImuConfig& config, std::uint64_t seed);
  [[nodiscard]] core::ImuSample sample(const Motion& motion, double t);

 private:
  ImuConfig config_;
  core::Rng rng_;
  Eigen::Vector3d accel_bias_, gyro_bias_;
  double last_ = 0.0;  // [s]
};

/// INI section [gps].
struct GpsConfig
{
  double rate_hz = 5.0;             ///< [1/s]
  double sigma_m = 0.25;            ///< [m] white, east and north
  double sigma_up_m = 0.5;          ///< [m] white
  double bias_sigma_m = 0.4;        ///< [m] slow (Gauss-Markov), east and north; double for up
  double bias_time_s = 100.0;       ///< [s] correlation time of the slow part
  double velocity_sigma_mps = 0.1;  ///< [m/s] of the speed over ground
  double delay_s = 0.0;             ///< [s] age of the reading at its time stamp
  double bias_walk = 0.0;           ///< [m/sqrt(s)] random walk of the bias, east and north
  double outage_start_s = 0.0;      ///< [s] no fix from here on ...
  double outage_s = 0.0;            ///< [s] ... for so long
  double jump_time_s = 0.0;         ///< [s] from here on all fixes are off by jump_m
  Eigen::Vector3d jump_m = Eigen::Vector3d::Zero();               ///< [m]
  Eigen::Vector3d lever_m = Eigen::Vector3d::Zero();              ///< [m] antenna in the body frame
  Eigen::Vector3d datum = Eigen::Vector3d(47.3667, 8.55, 450.0);  ///< lat, lon [deg], alt [m]

  template <class Self, class Visit>
  static void fields(Self& c, Visit&& v)
  {
    using core::Range;
    v("rate_hz", c.rate_hz, Range{0.1, 50.0}, "fixes per second");
    v("sigma_m", c.sigma_m, Range{0.0, 50.0}, "white noise, east and north");
    v("sigma_up_m", c.sigma_up_m, Range{0.0, 50.0}, "white noise, up");
    v("bias_sigma_m", c.bias_sigma_m, Range{0.0, 50.0}, "slow error; double for up");
    v("bias_time_s", c.bias_time_s, Range{1.0, 1e5}, "correlation time of the slow error");
    v("velocity_sigma_mps", c.velocity_sigma_mps, Range{0.0, 10.0}, "noise of speed over ground");
    v("delay_s", c.delay_s, Range{0.0, 2.0}, "age of a fix at its time stamp");
    v("bias_walk", c.bias_walk, Range{0.0, 10.0},
      "random walk of the slow error, m/sqrt(s); double for up");
    v("outage_start_s", c.outage_start_s, Range{0.0, 1e6}, "no fix from here on ...");
    v("outage_s", c.outage_s, Range{0.0, 1e6}, "... for so long; 0 = none");
    v("jump_time_s", c.jump_time_s, Range{0.0, 1e6}, "from here on fixes are off by jump_m");
    v("jump_m", c.jump_m, "x,y,z by which fixes are off from jump_time_s on");
    v("lever_m", c.lever_m, "x,y,z of the antenna on the vehicle");
    v("datum", c.datum, "lat_deg,lon_deg,alt_m of the world's origin");
  }
};

class GpsModel
{
 public:
  GpsModel(const GpsConfig& config, std::uint64_t seed);
  /// What the receiver says at t about t - delay.
  [[nodiscard]] mrpt_io::GpsReading reading(const Motion& motion, double t);

 private:
  GpsConfig config_;
  core::Rng rng_;
  Eigen::Vector3d bias_;                              // Gauss-Markov
  Eigen::Vector3d walked_ = Eigen::Vector3d::Zero();  // without bound
  double last_ = 0.0;                                 // [s]
};

/// INI section [velocity].
struct VelocityConfig
{
  double rate_hz = 50.0;        ///< [1/s]
  double sigma_mps = 0.05;      ///< [m/s] white, per axis
  double outage_start_s = 0.0;  ///< [s] silent from here on ...
  double outage_s = 0.0;        ///< [s] ... for so long

  template <class Self, class Visit>
  static void fields(Self& c, Visit&& v)
  {
    using core::Range;
    v("rate_hz", c.rate_hz, Range{1.0, 500.0}, "samples per second");
    v("sigma_mps", c.sigma_mps, Range{0.0, 5.0}, "white noise per axis");
    v("outage_start_s", c.outage_start_s, Range{0.0, 1e6}, "silent from here on ...");
    v("outage_s", c.outage_s, Range{0.0, 1e6}, "... for so long; 0 = never");
  }
};

/// Velocity in world axes, as an autopilot reports it.
class VelocityModel
{
 public:
  VelocityModel(const VelocityConfig& config, std::uint64_t seed);
  [[nodiscard]] Eigen::Vector3d sample(const Motion& motion, double t);

 private:
  VelocityConfig config_;
  core::Rng rng_;
};

}  // namespace slalom::simulation
