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

  template <class Self, class Visit>
  static void fields(Self& c, Visit&& v)
  {
    v("radius_m", c.radius_m, Range{0.05, 5.0}, "radius of the sphere that encloses the vehicle");
    v("max_speed_mps", c.max_speed_mps, Range{0.05, 30.0}, "speed limit per axis");
    v("max_acceleration_mps2", c.max_acceleration_mps2, Range{0.05, 50.0},
      "acceleration limit per axis");
    v("max_yaw_rate_radps", c.max_yaw_rate_radps, Range{0.05, 10.0}, "yaw rate limit");
  }
};

}  // namespace slalom::core
