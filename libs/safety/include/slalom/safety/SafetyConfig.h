// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

#include "slalom/core/DistanceField.h"
#include "slalom/core/Fields.h"

namespace slalom::safety
{
/// What a command must satisfy to leave Slalom. INI section [safety].
struct SafetyConfig
{
  double state_timeout_s = 0.5;  ///< [s] an older state is not trusted: brake
  double map_timeout_s = 1.0;    ///< [s] an older map is not trusted: brake
  double plan_timeout_s = 2.0;   ///< [s] a refined reference verified longer ago: brake
  /// [m] Box in the world frame that the vehicle's centre must not leave; +-1e6 = no fence.
  double fence_min_x_m = -1e6, fence_min_y_m = -1e6, fence_min_z_m = -1e6;
  double fence_max_x_m = 1e6, fence_max_y_m = 1e6, fence_max_z_m = 1e6;
  bool verify_stop = true;  ///< a command must leave a way to stop; false as in the paper
  core::UnknownAs unknown = core::UnknownAs::Occupied;  ///< for the way to stop
  double lag_reserve_s = 0.05;  ///< [s] the vehicle may lag this much more than assumed
  /// [m] a stop along a plan may come this much nearer than the radius: what the simulated flight
  /// along the plan may err; braking straight away may not
  double graze_m = 0.03;
  double mover_horizon_s = 2.0;  ///< [s] moving obstacles are believed this far ahead
  double mover_sigmas = 2.0;     ///< [1] standard deviations of their place that are kept clear
  bool evade = true;  ///< where something would walk into a stop, a way aside counts as a stop, too
  double evasion_margin_m = 0.2;  ///< [m] beyond the radius that is left to such a way

  [[nodiscard]] Eigen::Vector3d fenceMin() const
  {
    return {fence_min_x_m, fence_min_y_m, fence_min_z_m};
  }
  [[nodiscard]] Eigen::Vector3d fenceMax() const
  {
    return {fence_max_x_m, fence_max_y_m, fence_max_z_m};
  }

  template <class Self, class Visit>
  static void fields(Self& c, Visit&& v)
  {
    using core::Level;
    using core::Range;
    using core::UnknownAs;
    v("state_timeout_s", c.state_timeout_s, Range{0.01, 60.0},
      "with a state older than this the vehicle brakes");
    v("map_timeout_s", c.map_timeout_s, Range{0.05, 60.0},
      "with a map older than this the vehicle brakes");
    v("plan_timeout_s", c.plan_timeout_s, Range{0.05, 60.0},
      "with a plan whose last check is older than this the vehicle brakes");
    v("fence_min_x_m", c.fence_min_x_m, Range{-1e6, 1e6}, "geofence, world frame; -1e6 = none");
    v("fence_min_y_m", c.fence_min_y_m, Range{-1e6, 1e6}, "geofence, world frame; -1e6 = none");
    v("fence_min_z_m", c.fence_min_z_m, Range{-1e6, 1e6}, "geofence, world frame; -1e6 = none");
    v("fence_max_x_m", c.fence_max_x_m, Range{-1e6, 1e6}, "geofence, world frame; 1e6 = none");
    v("fence_max_y_m", c.fence_max_y_m, Range{-1e6, 1e6}, "geofence, world frame; 1e6 = none");
    v("fence_max_z_m", c.fence_max_z_m, Range{-1e6, 1e6}, "geofence, world frame; 1e6 = none");
    v("verify_stop", c.verify_stop, "no command leaves that would lose the last way to stop");
    v("unknown", c.unknown,
      core::Names<UnknownAs>{{"free", UnknownAs::Free}, {"occupied", UnknownAs::Occupied}},
      "how that way treats space that was not seen");
    v("lag_reserve_s", c.lag_reserve_s, Range{0.0, 1.0},
      "a stop must not need the vehicle's lag to be better known than this", Level::Expert);
    v("graze_m", c.graze_m, Range{0.0, 0.5},
      "a stop along a plan may come this much nearer than the radius", Level::Expert);
    v("mover_horizon_s", c.mover_horizon_s, Range{0.0, 10.0},
      "how far ahead the motion of moving obstacles is believed", Level::Expert);
    v("mover_sigmas", c.mover_sigmas, Range{0.0, 6.0},
      "standard deviations of a moving obstacle's place that a stop keeps clear of", Level::Expert);
    v("evade", c.evade, "step aside, within known free space, for what would walk into a stop");
    v("evasion_margin_m", c.evasion_margin_m, Range{0.0, 2.0},
      "a command may count on stepping aside later as long as that passes this clear of movers",
      Level::Expert);
  }
};

}  // namespace slalom::safety
