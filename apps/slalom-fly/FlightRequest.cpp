// SPDX-License-Identifier: BSD-3-Clause
#include "FlightRequest.h"

#include <cmath>
#include <sstream>

#include "FlightHost.h"
#include "InputFiles.h"

namespace slalom::fly
{
namespace
{
Eigen::Vector3d pointOf(const std::string& option, const std::string& text)
{
  const auto refuse = [&]
  { throw app::UsageError(option + " " + text + ": three finite numbers x,y,z are needed"); };
  Eigen::Vector3d point;
  std::istringstream parts(text);
  std::string part;
  for (int axis = 0; axis < 3; ++axis)
  {
    std::size_t used = 0;
    if (!std::getline(parts, part, ',')) refuse();
    try
    {
      point[axis] = std::stod(part, &used);
    }
    catch (const std::exception&)
    {
      refuse();
    }
    if (part.find_first_not_of(" \t", used) != std::string::npos) refuse();
  }
  if (std::getline(parts, part) || !point.allFinite()) refuse();
  return point;
}

app::FlySettings readSettings(const Options& options)
{
  mrpt_io::IniDocument document = options.common.document();
  if (!options.vehicle_state.empty())
    document.set(options.vehicle_state == "truth" ? "state.source=truth" : "state.source=fusion");
  // A simulation has all sensors; auto would only have to find that out.
  else if (const auto* source = document.find("state", "source"); !source || source->text == "auto")
    document.set("state.source=fusion");
  if (options.time_limit_s)
    document.set("fly.time_limit_s=" + std::to_string(*options.time_limit_s));
  return app::readFlySettings(document);
}

engine::Mission missionOf(const Options& options, const engine::EngineConfig& config)
{
  engine::Mission mission;
  if (!options.waypoints.empty()) mission = app::readMission(options.waypoints, config);
  if (options.goal.empty()) return mission;
  const Eigen::Index n = mission.waypoints_W.cols();
  mission.waypoints_W.conservativeResize(3, n + 1);
  mission.waypoints_W.col(n) = pointOf("--goal", options.goal);
  return mission;
}

/// From the start on. @throws UsageError naming what cannot be flown
void check(const engine::Mission& mission, const Eigen::Vector3d& start,
           const engine::EngineConfig& config)
{
  engine::Mission whole;
  whole.waypoints_W.resize(3, mission.waypoints_W.cols() + 1);
  whole.waypoints_W << start, mission.waypoints_W;
  try
  {
    engine::check(whole, config);
  }
  catch (const std::invalid_argument& error)
  {
    throw app::UsageError(std::string("--start, --goal, --waypoints: ") + error.what());
  }
}

double headingTo(const engine::Mission& mission, const Eigen::Vector3d& from)
{
  for (const auto& waypoint : mission.waypoints_W.colwise())
    if (const Eigen::Vector3d way = waypoint - from; way.head<2>().norm() > 0.1)
      return std::atan2(way.y(), way.x());
  return 0.0;
}
}  // namespace

FlightRequest readRequest(const Options& options)
{
  if (options.world.empty() || options.start.empty())
    throw app::UsageError("--world and --start are needed");
  if (options.goal.empty() && options.waypoints.empty())
    throw app::UsageError("--goal or --waypoints is needed");
  app::FlySettings settings = readSettings(options);
  engine::Mission mission = missionOf(options, settings.engine);
  simulation::FlightStart start;
  start.p_W = pointOf("--start", options.start);
  check(mission, start.p_W, settings.engine);
  start.yaw = headingTo(mission, start.p_W);
  start.radius_m = settings.engine.vehicle.radius_m;
  return {std::move(settings),
          app::loaded([&] { return simulation::World::load(options.world, options.seed); }),
          std::move(mission), start};
}

}  // namespace slalom::fly
