// SPDX-License-Identifier: BSD-3-Clause
// The tracker plugin seen by a host of the same build: configuration, observations, time, records.
#include <gtest/gtest.h>
#include <mrpt/config/CConfigFileMemory.h>
#include <mrpt/maps/CSimplePointsMap.h>
#include <mrpt/obs/CObservationPointCloud.h>
#include <mrpt/obs/CObservationRobotPose.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "MockRobot3D.h"
#include "slalom/core/CycleRecord.h"

namespace slalom
{
namespace
{
using mrpt::math::TPoint3D;
using mrpt::nav::CAbstractNavigator;
using navigator::NavigationParams3D;

std::unique_ptr<navigator::AbstractNavigator3D> makeTracker(navigator::RobotInterface3D& robot)
{
  navigator::NavigatorFactory::loadModule(SLALOM_TRACKER_MODULE);
  return navigator::NavigatorFactory::named("TrackerNavigatorFactory")->create(robot);
}

mrpt::config::CConfigFileMemory ini(const std::string& text)
{
  mrpt::config::CConfigFileMemory config;
  config.setContent(text);
  return config;
}

NavigationParams3D goalAt(double x, double y, double z)
{
  NavigationParams3D goal;
  goal.target3D = {x, y, z, 0, 0, 0};
  return goal;
}

std::string errorOf(const std::function<void()>& action)
{
  try
  {
    action();
  }
  catch (const std::exception& e)
  {
    return e.what();
  }
  return "no error";
}
#define EXPECT_SAYS(text, part)                                                                \
  EXPECT_PRED2([](const std::string& t, const std::string& p) { return t.find(p) != t.npos; }, \
               std::string(text), std::string(part))

/// In a room of 8 m radius with a pillar: delivers poses at 50 Hz, scans at 10 Hz and the truth.
class SensingRobot : public test::MockRobot3D
{
 public:
  double stamp_offset_s = 0.0;  ///< of the sensors' clock against the host's
  bool silent = false, sees_pillar = true;
  TPoint3D pillar{100, 0, 0};

  bool pullObservations(std::vector<mrpt::obs::CObservation::Ptr>& out) override
  {
    out.insert(out.end(), queue_.begin(), queue_.end());
    queue_.clear();
    return true;
  }
  /// Flies 50 ms and senses on the way.
  void flyOn()
  {
    for (int i = 0; i < 5; ++i)
    {
      advance(0.01);
      ++tick_;
      if (silent) continue;
      if (tick_ % 2 == 0) pose("pose"), pose("GROUND_TRUTH");
      if (tick_ % 10 == 0) scan();
    }
  }
  int truths = 0, scans = 0;

 private:
  template <class Observation>
  std::shared_ptr<Observation> stamped(const std::string& label)
  {
    auto observation = std::make_shared<Observation>();
    observation->timestamp = mrpt::Clock::fromDouble(1.6e9 + t + stamp_offset_s);
    observation->sensorLabel = label;
    return observation;
  }
  void pose(const std::string& label)
  {
    auto observation = stamped<mrpt::obs::CObservationRobotPose>(label);
    observation->pose.mean = mrpt::poses::CPose3D(state.pose);
    observation->pose.cov.setDiagonal(1e-4);
    truths += label == "GROUND_TRUTH";
    queue_.push_back(observation);
  }
  void scan()
  {
    auto observation = stamped<mrpt::obs::CObservationPointCloud>("lidar");
    auto cloud = mrpt::maps::CSimplePointsMap::Create();
    const auto& p = state.pose;
    for (int a = 0; a < 240; ++a)
      for (int e = -10; e <= 10; ++e)
      {
        const double azimuth = a * std::numbers::pi / 120,
                     elevation = e * 3 * std::numbers::pi / 180;
        const double c = std::cos(azimuth), s = std::sin(azimuth);
        double flat = hit(p.x, p.y, c, s, 0.0, 0.0, 8.0, false);
        if (sees_pillar) flat = std::min(flat, hit(p.x, p.y, c, s, pillar.x, pillar.y, 0.4, true));
        const double dz = std::tan(elevation);
        if (dz < 0.0) flat = std::min(flat, -p.z / dz);
        // The vehicle's yaw turns the sensor.
        const double b = azimuth - p.yaw;
        cloud->insertPoint(float(flat * std::cos(b)), float(flat * std::sin(b)), float(flat * dz));
      }
    observation->pointcloud = cloud;
    ++scans;
    queue_.push_back(observation);
  }
  /// Distance along the ray (c,s) to the circle; `from_outside`: its near side.
  static double hit(double x, double y, double c, double s, double cx, double cy, double r,
                    bool from_outside)
  {
    const double along = (cx - x) * c + (cy - y) * s;
    const double across2 = std::pow(cx - x, 2) + std::pow(cy - y, 2) - along * along;
    const double half2 = r * r - across2;
    if (half2 < 0.0 || (from_outside && along < 0.0)) return 1e3;
    return from_outside ? along - std::sqrt(half2) : along + std::sqrt(half2);
  }
  std::vector<mrpt::obs::CObservation::Ptr> queue_;
  int tick_ = 0;
};

const char* const kByPose = "[state]\nsource = pose_observation\n";

TEST(Tracker, ConfigurationMistakesAreNamed)
{
  test::MockRobot3D robot;
  const auto mistake = [&robot](const std::string& text)
  { return errorOf([&] { makeTracker(robot)->loadConfigFile(ini(text)); }); };
  const std::string range = mistake("[vehicle]\nradius_m = 99\n");
  for (const char* part : {"[vehicle]", "radius_m", "99", "5"}) EXPECT_SAYS(range, part);
  EXPECT_SAYS(mistake("[vehicle]\nradius_m = 1.5x\n"), "1.5x");
  EXPECT_SAYS(mistake("[vehicle]\nradiusm = 0.3\n"), "radius_m");
  EXPECT_SAYS(mistake("[vehicel]\nradius_m = 0.3\n"), "vehicle");
  EXPECT_SAYS(mistake("[vehicle]\nradius_m = 3.0\n"), "clearance_m");  // rule between fields
  EXPECT_SAYS(mistake("[CAbstractNavigator]\nalarm_seems_not_approaching_target_timeout = soon\n"),
              "alarm_seems_not_approaching_target_timeout");
  EXPECT_SAYS(mistake("[CAbstractNavigator]\nalarm = 3\n"), "alarm");
  EXPECT_EQ(mistake("[my_robot]\nport = 7\n[replay]\nx = 1\n"), "no error");
}

TEST(Tracker, SettingsInForceAreTold)
{
  test::MockRobot3D robot;
  const auto tracker = makeTracker(robot);
  tracker->loadConfigFile(
      ini("[vehicle]\nmax_speed_mps = 0.9\n[CAbstractNavigator]\n"
          "alarm_seems_not_approaching_target_timeout = 12\n"));
  EXPECT_SAYS(tracker->effectiveConfig(), "max_speed_mps = 0.9");
  EXPECT_SAYS(tracker->effectiveConfig(), "[global_planner]");
  EXPECT_EQ(tracker->params_abstract_navigator.alarm_seems_not_approaching_target_timeout, 12.0);
  mrpt::config::CConfigFileMemory saved;
  tracker->saveConfigFile(saved);
  EXPECT_EQ(saved.read_double("vehicle", "max_speed_mps", 0.0), 0.9);
  EXPECT_EQ(
      saved.read_double("CAbstractNavigator", "alarm_seems_not_approaching_target_timeout", 0.0),
      12.0);
}

TEST(Tracker, RefusesWhatItCannotDo)
{
  test::MockRobot3D robot;
  const auto fusion = makeTracker(robot);
  fusion->loadConfigFile(ini("[state]\nsource = fusion\n"));
  EXPECT_SAYS(errorOf([&] { fusion->initialize(); }), "pullObservations");

  const auto tracker = makeTracker(robot);
  NavigationParams3D goal = goalAt(3, 0, 2);
  EXPECT_SAYS(errorOf([&] { tracker->navigate(&goal); }), "initialize()");
  EXPECT_SAYS(errorOf([&] { tracker->navigationStep(); }), "initialize()");
  tracker->initialize();
  goal.allowed_distance_m = 0.1;
  EXPECT_SAYS(errorOf([&] { tracker->navigate(&goal); }), "goal_tolerance_m");
}

TEST(Tracker, MapsWithoutAMission)
{
  SensingRobot robot;
  robot.state.pose.z = 2.0;
  const auto tracker = makeTracker(robot);
  tracker->loadConfigFile(ini(kByPose));
  std::vector<core::CycleRecord> cycles;
  int truths = 0;
  tracker->setCycleListener([&](const core::CycleRecord& cycle) { cycles.push_back(cycle); });
  tracker->setTruthListener(
      [&](double t, const mrpt::math::TPose3D& pose)
      {
        EXPECT_GE(t, 0.0);
        EXPECT_NEAR(pose.z, 2.0, 1e-9);
        ++truths;
      });
  tracker->initialize();
  for (int i = 0; i < 40; ++i)
  {
    robot.flyOn();
    tracker->navigationStep();
  }
  EXPECT_EQ(robot.commands, 0);
  ASSERT_EQ(cycles.size(), 40u);
  // Log time begins with the first observation, at 20 ms.
  for (std::size_t i = 0; i < cycles.size(); ++i)
    EXPECT_NEAR(cycles[i].t, 0.05 * double(i + 1) - 0.02, 1e-6);
  EXPECT_EQ(cycles.back().status, "NO_MISSION");
  EXPECT_NEAR(cycles.back().state.p_W.z(), 2.0, 0.05);
  ASSERT_TRUE(cycles.back().field);
  EXPECT_EQ(truths, robot.truths);

  const auto json = nlohmann::json::parse(tracker->runStatisticsJson());
  EXPECT_NEAR(json["epoch_s"].get<double>(), 1.6e9 + 0.02, 1e-3);
  EXPECT_EQ(json["points_per_scan"]["n"], robot.scans);
  EXPECT_EQ(json["points_per_scan"]["max"], 240 * 21);
  EXPECT_EQ(json["state_source"], "pose_observation");
}

struct Flight
{
  std::uint64_t hash = 0;
  std::vector<std::string> log;
  std::string last;
  TPoint3D end;
  double nearest_to_pillar_m = 1e9;
  std::vector<double> commands;
};
Flight flyPastThePillar(double stamp_offset_s = 0.0, bool sees_pillar = true)
{
  SensingRobot robot;
  robot.stamp_offset_s = stamp_offset_s;
  robot.sees_pillar = sees_pillar;
  robot.state.pose = {-4, 0, 2, 0, 0, 0};
  robot.pillar = {0, 0.1, 0};
  const auto tracker = makeTracker(robot);
  tracker->loadConfigFile(ini(kByPose));
  Flight flight;
  tracker->setCycleListener(
      [&](const core::CycleRecord& c)
      {
        flight.hash = c.decision_hash;
        flight.last = c.status + ": " + c.reason + " " + c.refinement.outcome;
      });
  tracker->initialize();
  const NavigationParams3D goal = goalAt(4, 0, 2);
  tracker->navigate(&goal);
  for (int i = 0; i < 800 && tracker->getCurrentState() == CAbstractNavigator::NAVIGATING; ++i)
  {
    robot.flyOn();
    tracker->navigationStep();
    flight.commands.insert(flight.commands.end(), {robot.flown.vx, robot.flown.vy, robot.flown.vz});
    const auto& p = robot.state.pose;
    flight.nearest_to_pillar_m = std::min(
        flight.nearest_to_pillar_m, std::hypot(p.x - robot.pillar.x, p.y - robot.pillar.y) - 0.4);
  }
  EXPECT_EQ(tracker->getCurrentState(), CAbstractNavigator::IDLE) << flight.last;
  flight.log = robot.log;
  flight.end = robot.state.pose.translation();
  return flight;
}

TEST(Tracker, FliesAroundWhatItSensesAndRepeatsItself)
{
  const Flight first = flyPastThePillar();
  EXPECT_LT((first.end - TPoint3D(4, 0, 2)).norm(), 0.6);
  EXPECT_GT(first.nearest_to_pillar_m, 0.35) << "the vehicle's radius";
  EXPECT_EQ(std::count(first.log.begin(), first.log.end(), "GOAL_REACHED"), 1);
  EXPECT_EQ(std::count(first.log.begin(), first.log.end(), "end"), 1);
  EXPECT_LT(flyPastThePillar(0.0, false).nearest_to_pillar_m, 0.0) << "the pillar is in the way";
  const Flight second = flyPastThePillar();
  EXPECT_EQ(first.hash, second.hash);
  EXPECT_EQ(first.commands, second.commands);
  // Sensors on another clock: log time follows their stamps.
  const Flight elsewhere = flyPastThePillar(-5e7);
  EXPECT_LT((elsewhere.end - TPoint3D(4, 0, 2)).norm(), 0.6);
}

TEST(Tracker, TimeGoesOnWhenSensorsFallSilent)
{
  SensingRobot robot;
  robot.state.pose = {-4, 0, 2, 0, 0, 0};
  const auto tracker = makeTracker(robot);
  tracker->loadConfigFile(ini(kByPose));
  double t = 0.0;
  tracker->setCycleListener([&](const core::CycleRecord& cycle) { t = cycle.t; });
  tracker->initialize();
  const NavigationParams3D goal = goalAt(4, 0, 2);
  tracker->navigate(&goal);
  for (int i = 0; i < 60; ++i)
  {
    robot.flyOn();
    tracker->navigationStep();
  }
  EXPECT_GT(std::hypot(robot.flown.vx, robot.flown.vy), 0.2);
  robot.silent = true;
  const double before = t;
  for (int i = 0; i < 60; ++i)
  {
    robot.flyOn();
    tracker->navigationStep();
  }
  EXPECT_NEAR(t - before, 3.0, 0.06);
  EXPECT_NEAR(std::hypot(robot.flown.vx, robot.flown.vy), 0.0, 1e-3) << "blind, it must brake";
}

TEST(Tracker, GivesUpAVehicleThatCannotMove)
{
  SensingRobot robot;
  robot.state.pose = {-4, 0, 2, 0, 0, 0};
  const auto tracker = makeTracker(robot);
  tracker->loadConfigFile(ini(std::string(kByPose) + "[mission]\nblocked_timeout_s = 3\n"));
  tracker->initialize();
  const NavigationParams3D goal = goalAt(4, 0, 2);
  tracker->navigate(&goal);
  const auto fly = [&](int steps)
  {
    for (int i = 0; i < steps && tracker->getCurrentState() == CAbstractNavigator::NAVIGATING; ++i)
    {
      robot.flyOn();
      tracker->navigationStep();
    }
  };
  fly(40);
  EXPECT_EQ(tracker->getCurrentState(), CAbstractNavigator::NAVIGATING);
  EXPECT_GT(std::hypot(robot.flown.vx, robot.flown.vy), 0.2);
  robot.jammed = true;
  fly(200);
  ASSERT_EQ(tracker->getCurrentState(), CAbstractNavigator::NAV_ERROR);
  EXPECT_SAYS(tracker->getErrorReason().error_msg, "UNREACHABLE");
  EXPECT_TRUE(robot.flown.isStopCmd());
  tracker->navigationStep();
  const auto at = [&robot](const std::string& event)
  { return std::find(robot.log.begin(), robot.log.end(), event) - robot.log.begin(); };
  const auto told = std::ptrdiff_t(robot.log.size());
  EXPECT_LT(at("SAFE_STOP"), at("UNREACHABLE")) << "the position does not follow the commands";
  EXPECT_LT(at("UNREACHABLE"), at("FAILED"));
  EXPECT_LT(at("FAILED"), told);
  EXPECT_EQ(robot.count("error end"), 1);
  EXPECT_EQ(robot.count("UNREACHABLE"), 1);
}

TEST(Tracker, TellsOfAStopForSafetyAndOfTheRecovery)
{
  SensingRobot robot;
  robot.state.pose = {-6, 0, 2, 0, 0, 0};
  const auto tracker = makeTracker(robot);
  tracker->loadConfigFile(ini(kByPose));
  tracker->initialize();
  const NavigationParams3D goal = goalAt(5, 0, 2);
  tracker->navigate(&goal);
  for (int i = 0; i < 600 && tracker->getCurrentState() == CAbstractNavigator::NAVIGATING; ++i)
  {
    robot.silent = i >= 60 && i < 120;
    robot.flyOn();
    tracker->navigationStep();
  }
  EXPECT_EQ(tracker->getCurrentState(), CAbstractNavigator::IDLE);
  EXPECT_EQ(robot.count("SAFE_STOP"), 1);
  EXPECT_EQ(robot.count("RECOVER"), 1);
  EXPECT_EQ(robot.count("GOAL_REACHED"), 1) << "every event once";
  const auto json = nlohmann::json::parse(tracker->runStatisticsJson());
  EXPECT_EQ(json["safe_stops"], 1);
  EXPECT_EQ(json["safe_recoveries"], 1);
}

TEST(Tracker, ListenersMayThrow)
{
  SensingRobot robot;
  robot.state.pose = {-4, 0, 2, 0, 0, 0};
  const auto tracker = makeTracker(robot);
  tracker->loadConfigFile(ini(kByPose));
  bool full = false;
  tracker->setCycleListener(
      [&](const core::CycleRecord&)
      {
        if (full) throw std::runtime_error("disk full");
      });
  tracker->initialize();
  const NavigationParams3D goal = goalAt(4, 0, 2);
  tracker->navigate(&goal);
  for (int i = 0; i < 10; ++i)
  {
    full = i >= 5;
    robot.flyOn();
    EXPECT_EQ(errorOf([&] { tracker->navigationStep(); }), full ? "disk full" : "no error");
    EXPECT_EQ(tracker->getCurrentState(), CAbstractNavigator::NAVIGATING);
  }
}

TEST(Tracker, WaitsForTheFirstObservation)
{
  SensingRobot robot;
  robot.silent = true;
  const auto tracker = makeTracker(robot);
  tracker->loadConfigFile(ini(kByPose));
  tracker->initialize();
  const NavigationParams3D goal = goalAt(4, 0, 2);
  tracker->navigate(&goal);
  for (int i = 0; i < 20; ++i)
  {
    robot.flyOn();
    tracker->navigationStep();
  }
  EXPECT_EQ(tracker->getCurrentState(), CAbstractNavigator::NAVIGATING);
  EXPECT_TRUE(robot.flown.isStopCmd());
  EXPECT_EQ(robot.details.at(0), "WAITING_FOR_STATE: no observation yet");
}

}  // namespace
}  // namespace slalom
