// SPDX-License-Identifier: BSD-3-Clause
#include "slalom/engine/EngineConfig.h"

#include <string>

#include "slalom/mrpt_io/ConfigBinder.h"

namespace slalom::engine
{
namespace
{
/// The one list of the engine's sections.
template <class Config, class Visit>
void sections(Config& config, Visit&& visit)
{
  visit("vehicle", config.vehicle);
  visit("engine", config.rates);
  visit("state", config.state);
  visit("mission", config.mission);
  visit("estimation", config.estimation);
  visit("mapping", config.mapping);
  visit("global_planner", config.global_planner);
  visit("local_planner", config.local_planner);
  visit("safety", config.safety);
  visit("tracking", config.tracking);
}

void require(bool holds, const std::string& rule)
{
  if (!holds) throw mrpt_io::ConfigError(rule);
}

std::string text(double value)
{
  std::string s = std::to_string(value);
  s.erase(s.find_last_not_of('0') + 1);
  if (s.back() == '.') s.pop_back();
  return s;
}

}  // namespace

void bind(mrpt_io::ConfigBinder& binder, EngineConfig& config)
{
  sections(config, [&binder](const char* name, auto& section) { binder.bind(name, section); });
}

void check(const EngineConfig& config)
{
  const auto& map = config.mapping;
  const auto& global = config.global_planner;
  const auto& local = config.local_planner;
  require(map.window_xy_m >= 2.0 * map.update_range_m,
          "mapping.window_xy_m = " + text(map.window_xy_m) +
              " must be at least 2 x update_range_m = " + text(2.0 * map.update_range_m) +
              ", or scans reach beyond the window");
  require(global.clearance_m > config.vehicle.radius_m + global.margin_m,
          "global_planner.clearance_m = " + text(global.clearance_m) +
              " must exceed vehicle.radius_m + global_planner.margin_m = " +
              text(config.vehicle.radius_m + global.margin_m));
  require(map.max_distance_m > global.clearance_m,
          "mapping.max_distance_m = " + text(map.max_distance_m) +
              " must exceed global_planner.clearance_m = " + text(global.clearance_m) +
              ", or the planner cannot see that distance");
  require(global.horizon_m <= map.window_xy_m,
          "global_planner.horizon_m = " + text(global.horizon_m) +
              " must fit mapping.window_xy_m = " + text(map.window_xy_m));
  require(global.min_altitude_m < global.max_altitude_m,
          "global_planner.min_altitude_m = " + text(global.min_altitude_m) +
              " must be below max_altitude_m = " + text(global.max_altitude_m));
  require(
      !config.safety.verify_stop || global.unknown != global_planner::UnknownPolicy::Free ||
          config.safety.unknown == core::UnknownAs::Free,
      "safety.unknown = occupied contradicts global_planner.unknown = free: the gate would stop "
      "what the planner plans");
  const auto& safety = config.safety;
  require(
      (safety.fenceMin().array() < safety.fenceMax().array()).all(),
      "safety.fence_min_x_m, .._y_m, .._z_m = " + text(safety.fence_min_x_m) + ", " +
          text(safety.fence_min_y_m) + ", " + text(safety.fence_min_z_m) +
          " must be below safety.fence_max_x_m, .._y_m, .._z_m = " + text(safety.fence_max_x_m) +
          ", " + text(safety.fence_max_y_m) + ", " + text(safety.fence_max_z_m));
  require(config.guarded().fence_min_z_m < config.guarded().fence_max_z_m,
          "safety.fence_min_z_m, fence_max_z_m = " + text(safety.fence_min_z_m) + ", " +
              text(safety.fence_max_z_m) +
              " leave nothing of global_planner.min_altitude_m, max_altitude_m = " +
              text(global.min_altitude_m) + ", " + text(global.max_altitude_m));
  require(safety.plan_timeout_s > config.rates.global_period_s,
          "safety.plan_timeout_s = " + text(safety.plan_timeout_s) +
              " must exceed engine.global_period_s = " + text(config.rates.global_period_s) +
              ", or every plan is too old before the next one comes");
  require(config.tracking.min_range_m < config.tracking.range_m,
          "tracking.min_range_m = " + text(config.tracking.min_range_m) +
              " must be below range_m = " + text(config.tracking.range_m));
  require(map.min_range_m < map.update_range_m,
          "mapping.min_range_m = " + text(map.min_range_m) +
              " must be below update_range_m = " + text(map.update_range_m));
  require(local.step_s * config.vehicle.max_speed_mps <= 2.0 * map.resolution_m,
          "local_planner.step_s x vehicle.max_speed_mps = " +
              text(local.step_s * config.vehicle.max_speed_mps) +
              " m must not exceed two voxels (2 x mapping.resolution_m = " +
              text(2.0 * map.resolution_m) + "), or a stage steps over an obstacle");
}

std::string describeEngineConfig()
{
  std::string markdown;
  EngineConfig defaults;
  sections(defaults, [&markdown](const char* name, const auto& section)
           { markdown += mrpt_io::describe(name, section) + "\n"; });
  return markdown;
}

}  // namespace slalom::engine
