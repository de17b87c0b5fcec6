// SPDX-License-Identifier: BSD-3-Clause
#include "FlightHost.h"

#include <mrpt/config/CConfigFileMemory.h>

#include <iostream>
#include <map>
#include <nlohmann/json.hpp>

#include "Program.h"
#include "Sha256.h"
#include "slalom/report/OutputFolder.h"
#include "slalom/spline/WaypointFile.h"

namespace slalom::app
{
namespace
{
navigator::NavigationParams3D goalOf(const engine::Mission& mission, double tolerance)
{
  navigator::NavigationParams3D goal;
  const auto point = [&](Eigen::Index i)
  {
    const Eigen::Vector3d p = mission.waypoints_W.col(i);
    return mrpt::math::TPoint3D(p.x(), p.y(), p.z());
  };
  const Eigen::Index last = mission.waypoints_W.cols() - 1;
  for (Eigen::Index i = 0; i < last; ++i) goal.waypoints.push_back(point(i));
  const mrpt::math::TPoint3D end = point(last);
  goal.target3D = mrpt::math::TPose3D(end.x, end.y, end.z, 0.0, 0.0, 0.0);
  goal.allowed_distance_m = tolerance;
  return goal;
}
}  // namespace

engine::Mission readMission(const std::filesystem::path& file, const engine::EngineConfig& config)
{
  try
  {
    const engine::Mission mission{spline::readWaypoints(file).points_W};
    engine::check(mission, config);
    return mission;
  }
  catch (const std::invalid_argument& error)
  {
    throw mrpt_io::ConfigError(file.string() + ": " + error.what());
  }
  catch (const std::runtime_error& error)
  {
    throw mrpt_io::ConfigError(error.what());
  }
}

void prepareFolder(const std::filesystem::path& folder, bool overwrite)
{
  if (folder.empty()) throw UsageError("--out: an output folder is needed");
  try
  {
    report::prepareOutputFolder(folder, overwrite);
  }
  catch (const report::OutputError& error)
  {
    throw UsageError(error.what());
  }
}

FlightHost::FlightHost(const HostSettings& settings, const PluginConfig& plugin,
                       navigator::RobotInterface3D& robot, std::filesystem::path out)
    : settings_(settings), plugin_(plugin), robot_(robot), out_(std::move(out))
{
}

FlightHost::~FlightHost() = default;

void FlightHost::open(std::function<void(report::RunInfo&)> describe)
{
  describe_ = std::move(describe);
  navigator::NavigatorFactory::loadModule(plugin_.plugin);
  navigator_ = navigator::NavigatorFactory::named(plugin_.navigator)->create(robot_);
  mrpt::config::CConfigFileMemory config;
  settings_.document.copyTo(config);
  navigator_->loadConfigFile(config);
  navigator_->setCycleListener([this](const core::CycleRecord& cycle) { onCycle(cycle); });
  navigator_->setTruthListener([this](double t, const mrpt::math::TPose3D& pose)
                               { onTruth(t, pose); });
  navigator_->initialize();
  mrpt::Clock::setActiveClock(mrpt::Clock::Source::Simulated);
}

void FlightHost::navigate(const engine::Mission& mission)
{
  const auto goal = goalOf(mission, settings_.engine.mission.goal_tolerance_m);
  navigator_->navigate(&goal);
}

void FlightHost::step(double now)
{
  mrpt::Clock::setSimulatedTime(mrpt::Clock::fromDouble(now));
  navigator_->navigationStep();
}

void FlightHost::onTruth(double t, const mrpt::math::TPose3D& pose)
{
  core::TimedPose timed;
  timed.t = t;
  timed.position = {pose.x, pose.y, pose.z};
  mrpt::math::CQuaternionDouble q;
  pose.getAsQuaternion(q);
  timed.orientation = Eigen::Quaterniond(q.r(), q.x(), q.y(), q.z());
  if (report_)
    report_->addTruth(timed);
  else
    early_truth_.push_back(timed);
}

void FlightHost::onCycle(const core::CycleRecord& cycle)
{
  ensureReport();
  status_ = cycle.status;
  goal_reached_ = goal_reached_ || cycle.status == "GOAL_REACHED";
  if (cycle.reference.cols() > 0) distance_to_goal_ = cycle.distance_to_goal_m;
  report_->add(cycle);
}

void FlightHost::ensureReport()
{
  if (report_) return;
  report::RunInfo info;
  const auto statistics = nlohmann::json::parse(navigator_->runStatisticsJson());
  info.epoch_s = statistics.value("epoch_s", 0.0);
  info.vehicle_radius_m = info.hard_clearance_m = settings_.engine.vehicle.radius_m;
  info.wanted_clearance_m = settings_.engine.global_planner.clearance_m;
  info.max_speed_mps = settings_.engine.vehicle.max_speed_mps;
  info.setpoint_lead_s = settings_.engine.local_planner.step_s;
  info.map_deadline_s = info.global_deadline_s = settings_.engine.rates.global_period_s;
  info.local_deadline_s = settings_.engine.rates.local_period_s;
  info.effective_ini = settings_.effective;
  info.version = SLALOM_VERSION;
  info.build = SLALOM_BUILD_TYPE;
  info.method = plugin_.method;
  info.config_sha256 = sha256OfText(settings_.effective);
  info.threads = settings_.engine.rates.threaded ? 3 : 1;
  describe_(info);
  report_ = std::make_unique<report::FlightReport>(settings_.report, out_, std::move(info));
  for (const core::TimedPose& pose : early_truth_) report_->addTruth(pose);
  early_truth_.clear();
}

report::InputSummary FlightHost::inputSummary() const
{
  report::InputSummary input;
  const auto statistics = nlohmann::json::parse(navigator_->runStatisticsJson());
  input.dropped = statistics.value("dropped", std::map<std::string, std::uint64_t>{});
  if (const auto points = statistics.find("points_per_scan");
      points != statistics.end() && points->is_object())
  {
    if ((*points)["median"].is_number())
      input.points_per_scan_median = (*points)["median"].get<double>();
    if ((*points)["max"].is_number()) input.points_per_scan_max = (*points)["max"].get<double>();
  }
  return input;
}

void FlightHost::finish(const report::RunSummary& summary, bool with_map)
{
  ensureReport();
  if (with_map && settings_.engine.mapping.keep_octree &&
      !navigator_->writeMap((out_ / "map.bt").string()))
    std::cerr << "warning: map.bt could not be written\n";
  report_->finish(summary);
}

}  // namespace slalom::app
