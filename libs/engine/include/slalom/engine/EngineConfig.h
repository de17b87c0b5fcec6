// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <string>

#include "slalom/core/Fields.h"
#include "slalom/core/Vehicle.h"
#include "slalom/estimation/FilterConfig.h"
#include "slalom/global_planner/GlobalPlannerConfig.h"
#include "slalom/local_planner/LocalPlannerConfig.h"
#include "slalom/mapping/MapperConfig.h"
#include "slalom/safety/SafetyConfig.h"
#include "slalom/tracking/TrackingConfig.h"

namespace slalom::mrpt_io
{
class ConfigBinder;
}

namespace slalom::engine
{
/// Where the vehicle's state comes from.
enum class StateSourceKind
{
  Auto,             ///< fusion when there is GPS or velocity, else poses, else static
  Fusion,           ///< error-state filter on GPS, IMU and velocity
  PoseObservation,  ///< poses of an external source
  Static,           ///< the vehicle stands still at the origin
  Truth             ///< ground-truth poses of a simulator
};

/// INI section [state].
struct StateConfig
{
  StateSourceKind source = StateSourceKind::Auto;
  double wait_s = 5.0;  ///< [s] Auto: without any usable source for this long, stand still
  double anchor_rate_mps = 0.05;  ///< [m/s] how fast the mission follows a drifting local frame

  template <class Self, class Visit>
  static void fields(Self& c, Visit&& v)
  {
    using K = StateSourceKind;
    v("source", c.source,
      core::Names<K>{{"auto", K::Auto},
                     {"fusion", K::Fusion},
                     {"pose_observation", K::PoseObservation},
                     {"static", K::Static},
                     {"truth", K::Truth}},
      "where the vehicle's pose comes from");
    v("wait_s", c.wait_s, core::Range{0.0, 600.0}, "auto: how long to wait for a usable source",
      core::Level::Expert);
    v("anchor_rate_mps", c.anchor_rate_mps, core::Range{0.0, 10.0},
      "how fast the mission is moved when GPS corrects the position", core::Level::Expert);
  }
};

/// INI section [mission].
struct MissionConfig
{
  double goal_tolerance_m = 0.5;  ///< [m]
  double max_length_m = 20000.0;  ///< [m] a longer mission is refused: its reference takes memory
  double knot_span_s = 0.2;       ///< [s] of the reference spline
  double speed_share = 0.9;       ///< [1] of the vehicle's speed limit that plans use
  double acceleration_share =
      0.7;  ///< [1] of its acceleration limit that plans use; the rest is for tracking
  double max_lead_s = 0.6;  ///< [s] how far the reference may run ahead of a delayed vehicle
  double progress_timeout_s = 60.0;  ///< [s] no farther on R for longer: UNREACHABLE
  double blocked_timeout_s = 20.0;   ///< [s] standing in mid-mission for longer: UNREACHABLE
  double sensor_timeout_s = 10.0;    ///< [s] stopped for want of a sensor for longer: SENSOR_LOST

  template <class Self, class Visit>
  static void fields(Self& c, Visit&& v)
  {
    using core::Level;
    using core::Range;
    v("goal_tolerance_m", c.goal_tolerance_m, Range{0.01, 100.0},
      "the goal counts as reached within this");
    v("max_length_m", c.max_length_m, Range{1.0, 1e6},
      "a mission longer than this is refused; its reference takes memory in proportion");
    v("knot_span_s", c.knot_span_s, Range{0.02, 1.0}, "knot span of the reference spline",
      Level::Expert);
    v("speed_share", c.speed_share, Range{0.1, 1.0},
      "share of the vehicle's speed limit that plans use; the rest is reserve");
    v("acceleration_share", c.acceleration_share, Range{0.1, 1.0},
      "share of its acceleration limit that plans use; the rest is left to tracking");
    v("max_lead_s", c.max_lead_s, Range{0.0, 10.0},
      "how far the reference may run ahead of a delayed vehicle", Level::Expert);
    v("progress_timeout_s", c.progress_timeout_s, Range{1.0, 3600.0},
      "a vehicle that flies but comes no farther on its reference for this long reports "
      "UNREACHABLE");
    v("blocked_timeout_s", c.blocked_timeout_s, Range{1.0, 3600.0},
      "a vehicle that found no way on for this long reports UNREACHABLE");
    v("sensor_timeout_s", c.sensor_timeout_s, Range{0.1, 3600.0},
      "a vehicle that stopped because a sensor is silent or too slow reports SENSOR_LOST after "
      "this long, and its mission has failed");
  }
};

/// INI section [engine].
struct RateConfig
{
  double local_period_s = 0.05;  ///< [s] one local planner step per period
  double global_period_s = 0.1;  ///< [s] at most one global step per period and per new map
  bool threaded = false;    ///< mapper and global planner in their own threads (not reproducible)
  bool open_loop = false;   ///< nobody flies the commands, as in a replay
  bool require_map = true;  ///< false: without any range data, track R as it is

  template <class Self, class Visit>
  static void fields(Self& c, Visit&& v)
  {
    using core::Range;
    v("local_period_s", c.local_period_s, Range{0.005, 0.2},
      "period of the local planner and its deadline");
    v("global_period_s", c.global_period_s, Range{0.01, 10.0},
      "shortest time between two global steps and its deadline");
    v("threaded", c.threaded,
      "mapper and global planner in threads of their own; results then depend on timing");
    v("open_loop", c.open_loop,
      "nobody flies the commands, as in a replay: nothing is learned from how the vehicle answers",
      core::Level::Expert);
    v("require_map", c.require_map,
      "without a map: brake (true) or track the reference blindly (false)");
  }
};

struct EngineConfig
{
  core::Vehicle vehicle;
  RateConfig rates;
  StateConfig state;
  MissionConfig mission;
  estimation::FilterConfig estimation;
  mapping::MapperConfig mapping;
  global_planner::GlobalPlannerConfig global_planner;
  local_planner::LocalPlannerConfig local_planner;
  safety::SafetyConfig safety;
  tracking::TrackingConfig tracking;

  /// The vehicle with the limits that references are planned for.
  [[nodiscard]] core::Vehicle planned() const
  {
    core::Vehicle limited = vehicle;
    limited.max_speed_mps *= mission.speed_share;
    limited.max_acceleration_mps2 *= mission.acceleration_share;
    return limited;
  }

  /// What the gate works with: its fence, and the altitudes that plans keep to
  /// (global_planner.min_altitude_m, max_altitude_m), whichever is narrower.
  [[nodiscard]] safety::SafetyConfig guarded() const
  {
    safety::SafetyConfig guard = safety;
    guard.fence_min_z_m = std::max(guard.fence_min_z_m, global_planner.min_altitude_m);
    guard.fence_max_z_m = std::min(guard.fence_max_z_m, global_planner.max_altitude_m);
    return guard;
  }
};

/// Binds every section of the engine. @throws mrpt_io::ConfigError
void bind(mrpt_io::ConfigBinder& binder, EngineConfig& config);

/// Rules between fields: horizon inside the window, clearance above the radius, ... @throws
/// mrpt_io::ConfigError
void check(const EngineConfig& config);

/// All engine keys as Markdown, section by section.
[[nodiscard]] std::string describeEngineConfig();

}  // namespace slalom::engine
