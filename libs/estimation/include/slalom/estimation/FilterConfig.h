// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "slalom/core/Fields.h"

namespace slalom::estimation
{
/// INI section [estimation]. Noise densities are continuous-time.
struct FilterConfig
{
  double accel_noise = 0.05;      ///< [m/s^2/sqrt(Hz)]
  double gyro_noise = 0.002;      ///< [rad/s/sqrt(Hz)]
  double accel_bias_walk = 1e-3;  ///< [m/s^3/sqrt(Hz)]
  double gyro_bias_walk = 1e-4;   ///< [rad/s^2/sqrt(Hz)]
  double gate = 11.34;            ///< [1] chi-square threshold at 3 degrees of freedom (99 %)
  int max_rejects =
      20;  ///< [1] consecutive rejects of one source before it re-initialises the filter
  double max_delay_s = 0.5;          ///< [s] older measurements are dropped
  double max_extrapolation_s = 0.3;  ///< [s]
  double timeout_s = 1.0;            ///< [s] without position and velocity: DeadReckoning
  double min_imu_rate_hz = 40.0;     ///< [Hz] slower IMUs are not integrated
  double accel_bias_sigma = 0.15;    ///< [m/s^2] of the switch-on bias
  double gyro_bias_sigma = 0.01;     ///< [rad/s] of the switch-on bias
  double manoeuvre_noise = 2.0;      ///< [m/s^2/sqrt(Hz)] constant-velocity model, without IMU
  double turn_noise = 0.5;           ///< [rad/s/sqrt(Hz)] constant-heading model, without IMU
  double heading_patience_s = 5.0;   ///< [s] Running with unknown heading after this long

  template <class Self, class Visit>
  static void fields(Self& c, Visit&& v)
  {
    using core::Level;
    using core::Range;
    v("accel_noise", c.accel_noise, Range{1e-4, 10.0},
      "accelerometer noise density [m/s^2/sqrt(Hz)]");
    v("gyro_noise", c.gyro_noise, Range{1e-6, 1.0}, "gyroscope noise density [rad/s/sqrt(Hz)]");
    v("accel_bias_walk", c.accel_bias_walk, Range{0.0, 1.0}, "accelerometer bias random walk",
      Level::Expert);
    v("gyro_bias_walk", c.gyro_bias_walk, Range{0.0, 0.1}, "gyroscope bias random walk",
      Level::Expert);
    v("gate", c.gate, Range{1.0, 1000.0}, "chi-square gate of a 3-vector (11.34 is 99 %)",
      Level::Expert);
    v("max_rejects", c.max_rejects, Range{1, 1000},
      "consecutive rejected fixes of a source after which it is believed", Level::Expert);
    v("max_delay_s", c.max_delay_s, Range{0.0, 5.0}, "measurements later than this are dropped");
    v("max_extrapolation_s", c.max_extrapolation_s, Range{0.0, 2.0},
      "how far a state may be predicted beyond the newest measurement", Level::Expert);
    v("timeout_s", c.timeout_s, Range{0.05, 60.0},
      "without position and velocity for this long the state is dead reckoning");
    v("min_imu_rate_hz", c.min_imu_rate_hz, Range{1.0, 1000.0}, "slower IMUs are not integrated",
      Level::Expert);
    v("accel_bias_sigma", c.accel_bias_sigma, Range{1e-6, 5.0},
      "standard deviation of the accelerometer bias at switch-on [m/s^2]", Level::Expert);
    v("gyro_bias_sigma", c.gyro_bias_sigma, Range{1e-8, 1.0},
      "standard deviation of the gyroscope bias at switch-on [rad/s]", Level::Expert);
    v("manoeuvre_noise", c.manoeuvre_noise, Range{0.01, 50.0},
      "acceleration noise of the constant-velocity model that replaces a missing IMU",
      Level::Expert);
    v("turn_noise", c.turn_noise, Range{1e-3, 10.0},
      "turn-rate noise of the constant-heading model that replaces a missing IMU", Level::Expert);
    v("heading_patience_s", c.heading_patience_s, Range{0.0, 600.0},
      "how long to wait for an observable heading before running with an unknown one",
      Level::Expert);
  }
};

}  // namespace slalom::estimation
