// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "slalom/core/Fields.h"

namespace slalom::core
{
/// The vehicle as planners see it: a sphere with limits. INI section [vehicle].
struct Vehicle
{
  double radius_m = 0.35;              ///< [m] collision sphere
  double max_speed_mps = 1.2;          ///< [m/s] per axis
  double max_acceleration_mps2 = 1.0;  ///< [m/s^2] per axis
  double max_yaw_rate_radps = 1.0;     ///< [rad/s]
  /// Its velocity follows the command like exp(-t / this); 0 = at once, as in the paper.
  double velocity_lag_s = 0.2;
  double yaw_rate_lag_s = 0.0;   ///< likewise its yaw rate
  double command_delay_s = 0.0;  ///< [s] from the step that decides a command until it takes effect

  template <class Self, class Visit>
  static void fields(Self& c, Visit&& v)
  {
    v("radius_m", c.radius_m, Range{0.05, 5.0}, "radius of the sphere that encloses the vehicle");
    v("max_speed_mps", c.max_speed_mps, Range{0.05, 30.0}, "speed limit per axis");
    v("max_acceleration_mps2", c.max_acceleration_mps2, Range{0.05, 50.0},
      "acceleration limit per axis");
    v("max_yaw_rate_radps", c.max_yaw_rate_radps, Range{0.05, 10.0}, "yaw rate limit");
    v("velocity_lag_s", c.velocity_lag_s, Range{0.0, 2.0},
      "time constant with which the vehicle's velocity follows the command; 0 = at once");
    v("yaw_rate_lag_s", c.yaw_rate_lag_s, Range{0.0, 2.0},
      "time constant with which its yaw rate follows the command; 0 = at once");
    v("command_delay_s", c.command_delay_s, Range{0.0, 0.5},
      "from the step that decides a command until the vehicle begins to obey it");
  }
};

}  // namespace slalom::core
