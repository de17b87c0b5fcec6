// SPDX-License-Identifier: BSD-3-Clause
// Situations that a tracker must have an answer to, flown in closed loop. With SLALOM_GALLERY_DIR
// set, each leaves its report (pictures, rows) in a folder of that name below it.
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <memory>

#include "FlightHarness.h"
#include "SharedData.h"
#include "slalom/report/FlightReport.h"
#include "slalom/report/OutputFolder.h"

namespace slalom
{
namespace
{
using engine::EngineStatus;
using test::AnalyticField;
using test::FlightOutcome;
using test::Obstacle;
using test::VerticalCylinder;

Obstacle wall(double x0, double y0, double x1, double y1)
{
  return Eigen::AlignedBox3d(Eigen::Vector3d(x0, y0, -2.0), Eigen::Vector3d(x1, y1, 6.0));
}

engine::Mission to(const Eigen::Vector3d& goal)
{
  return {Eigen::Matrix3Xd(goal)};
}

/// Flies, and leaves a report where one is asked for.
FlightOutcome fly(const std::string& name, test::FlightWorld world,
                  const engine::EngineConfig& config, const Eigen::Vector3d& start,
                  const engine::Mission& mission, double time_limit_s)
{
  test::FlightHarness harness(std::move(world), config);
  harness.azimuths = 900;
  std::unique_ptr<report::FlightReport> book;
  if (const char* folder = std::getenv("SLALOM_GALLERY_DIR"))
  {
    const std::filesystem::path out = std::filesystem::path(folder) / name;
    report::prepareOutputFolder(out, true);
    report::ReportConfig pictures;
    pictures.picture_interval_s = 0.5;
    report::RunInfo info;
    info.title = name;
    info.vehicle_radius_m = info.hard_clearance_m = config.vehicle.radius_m;
    info.wanted_clearance_m = config.global_planner.clearance_m;
    book = std::make_unique<report::FlightReport>(pictures, out, info);
    harness.listener = [&](const core::CycleRecord& cycle, const Eigen::Vector3d&)
    { book->add(cycle); };
  }
  const FlightOutcome flight = harness.fly(start, mission, time_limit_s);
  if (book)
  {
    report::RunSummary summary;
    summary.result = {0, std::string(toString(flight.status)), "gallery", true};
    book->finish(summary);
  }
  testing::Test::RecordProperty("length_m", std::to_string(flight.length_m));
  testing::Test::RecordProperty("min_clearance_m", std::to_string(flight.min_clearance_m));
  std::printf("%-24s %-14s %6.2f m %6.1f s  clearance %.3f m  replans %lu, failed %lu\n",
              name.c_str(), std::string(toString(flight.status)).c_str(), flight.length_m,
              flight.duration_s, flight.min_clearance_m,
              static_cast<unsigned long>(flight.statistics.replans),
              static_cast<unsigned long>(flight.statistics.refined_failed));
  return flight;
}

FlightOutcome fly(const std::string& name, const AnalyticField& world, const Eigen::Vector3d& start,
                  const Eigen::Vector3d& goal, double time_limit_s)
{
  return fly(name, test::FlightWorld::of(world), test::flightConfig(), start, to(goal),
             time_limit_s);
}

void expectReached(const FlightOutcome& flight, double radius = 0.35)
{
  EXPECT_EQ(flight.status, EngineStatus::GoalReached) << toString(flight.status);
  EXPECT_GE(flight.min_clearance_m, radius);
  EXPECT_TRUE(flight.finite);
}

const Eigen::Vector3d kStart(0.0, 0.0, 1.5);

TEST(Gallery, WallWithTwoGapsIsPassedThroughTheNearerOne)
{
  const AnalyticField world(
      {wall(6, -20, 6.4, -4.0), wall(6, -2.2, 6.4, 1.2), wall(6, 3.0, 6.4, 20)});
  const FlightOutcome flight = fly("two_gap_wall", world, kStart, {12, 0, 1.5}, 60.0);
  expectReached(flight);
  EXPECT_LE(flight.length_m, 14.5) << "the gap at y = 2.1 m, not the one at -3.1 m";
}

TEST(Gallery, UTrapIsLeftAndFlownAround)
{
  const AnalyticField world(
      {wall(8, -2.0, 8.4, 2.0), wall(4, 1.6, 8.4, 2.0), wall(4, -2.0, 8.4, -1.6)});
  const FlightOutcome flight = fly("u_trap", world, kStart, {14, 0, 1.5}, 120.0);
  expectReached(flight);
  EXPECT_LE(flight.length_m, 30.0);
}

TEST(Gallery, CorridorOf1m8IsFlownThrough)
{
  const AnalyticField world({wall(3, 0.9, 13, 1.3), wall(3, -1.3, 13, -0.9)});
  const FlightOutcome flight = fly("corridor", world, kStart, {16, 0, 1.5}, 60.0);
  expectReached(flight);
  EXPECT_LE(flight.length_m, 17.0);
}

TEST(Gallery, ThickPillarIsFlownAround)
{
  const AnalyticField world({VerticalCylinder{{7.0, 0.2}, 1.5}});
  const FlightOutcome flight = fly("pillar", world, kStart, {14, 0, 1.5}, 60.0);
  expectReached(flight);
  EXPECT_LE(flight.length_m, 16.0);
}

TEST(Gallery, GoalInTrunkEndsBlockedBeforeIt)
{
  const AnalyticField world(
      {VerticalCylinder{{12.0, 0.0}, 0.75}, VerticalCylinder{{6.0, 0.1}, 0.3}});
  const FlightOutcome flight = fly("goal_in_trunk", world, kStart, {12, 0, 1.5}, 60.0);
  EXPECT_EQ(flight.status, EngineStatus::GoalBlocked) << toString(flight.status);
  EXPECT_GE(flight.min_clearance_m, 0.35);
}

TEST(Gallery, StartInsideTheDeadZoneGetsAway)
{
  const AnalyticField world({wall(-1, 0.42, 4, 0.8)});
  const FlightOutcome flight = fly("start_in_dead_zone", world, kStart, {10, 2, 1.5}, 60.0);
  expectReached(flight);
}

TEST(Gallery, BlindCornerIsNotRunInto)
{
  // A corridor that bends by 90 degrees, with a pillar just behind the corner.
  const AnalyticField world({wall(-2, 1.2, 7.0, 1.6), wall(-2, -1.6, 9.8, -1.2),
                             wall(9.4, -1.6, 9.8, 12), wall(6.6, 1.2, 7.0, 12),
                             VerticalCylinder{{8.9, 2.6}, 0.3}});
  Eigen::Matrix3Xd bend(3, 2);
  bend << 8.2, 8.2, 0.0, 9.0, 1.5, 1.5;
  const FlightOutcome flight =
      fly("blind_corner", test::FlightWorld::of(world), test::flightConfig(), kStart, {bend}, 60.0);
  expectReached(flight);
}

TEST(Gallery, SmallMazeIsSolved)
{
  const AnalyticField world({wall(3, -4, 3.3, 2.0), wall(6, -2.0, 6.3, 4), wall(9, -4, 9.3, 2.0),
                             wall(-2, 4, 12, 4.3), wall(-2, -4.3, 12, -4)});
  const FlightOutcome flight = fly("maze", world, kStart, {12, 0, 1.5}, 120.0);
  expectReached(flight);
}

TEST(Gallery, WallOfEightyMetresIsFlownAroundOrGivenUp)
{
  const AnalyticField world({wall(6, -40, 6.4, 40)});
  const FlightOutcome flight = fly("long_wall", world, kStart, {12, 0, 1.5}, 150.0);
  EXPECT_NE(flight.status, EngineStatus::Navigating) << toString(flight.status);
  EXPECT_GE(flight.min_clearance_m, 0.35);
}

TEST(Gallery, ClosedRoomEndsUnreachable)
{
  const AnalyticField world({wall(-3, 2.6, 3, 3.0), wall(-3, -3.0, 3, -2.6), wall(2.6, -3, 3.0, 3),
                             wall(-3.0, -3, -2.6, 3)});
  const FlightOutcome flight = fly("closed_room", world, kStart, {20, 0, 1.5}, 60.0);
  EXPECT_EQ(flight.status, EngineStatus::Unreachable) << toString(flight.status);
  EXPECT_GE(flight.min_clearance_m, 0.35);
}

TEST(Gallery, WaypointInsideATrunkIsSkipped)
{
  const AnalyticField world({VerticalCylinder{{6.0, 0.0}, 0.6}, VerticalCylinder{{9.0, 3.2}, 0.4}});
  Eigen::Matrix3Xd path(3, 3);
  path << 6, 9, 14, 0, 3, 3, 1.5, 1.5, 1.5;  // the first in a trunk, the second at another
  const FlightOutcome flight = fly("waypoint_in_trunk", test::FlightWorld::of(world),
                                   test::flightConfig(), kStart, {path}, 60.0);
  expectReached(flight);
  EXPECT_LE(flight.length_m, 19.0);
}

TEST(Gallery, GoalTakenForReachedNearEnough)
{
  const AnalyticField world({VerticalCylinder{{10.0, 0.0}, 0.4}});
  engine::EngineConfig config = test::flightConfig();
  config.global_planner.goal_policy = global_planner::GoalPolicy::NearestFree;
  config.global_planner.goal_radius_m = 2.0;
  const FlightOutcome flight = fly("goal_nearest_free", test::FlightWorld::of(world), config,
                                   kStart, to({10, 0, 1.5}), 60.0);
  expectReached(flight);
}

TEST(Gallery, GoalRejectedEndsTheMissionAtRest)
{
  const AnalyticField world({VerticalCylinder{{10.0, 0.0}, 0.4}});
  engine::EngineConfig config = test::flightConfig();
  config.global_planner.goal_policy = global_planner::GoalPolicy::Reject;
  const FlightOutcome flight =
      fly("goal_rejected", test::FlightWorld::of(world), config, kStart, to({10, 0, 1.5}), 60.0);
  EXPECT_EQ(flight.status, EngineStatus::GoalBlocked) << toString(flight.status);
  EXPECT_LE(flight.length_m, 8.0) << "it stops when the goal is seen to be occupied";
  EXPECT_GE(flight.min_clearance_m, 0.35);
}

/// The setting of the forest comparison: 2 m/s, 3 m/s2, radius 0.3 m, range 5 m. Gaps of less than
/// a metre between trunks ask for small voxels and a small wanted clearance.
engine::EngineConfig forestConfig()
{
  engine::EngineConfig config = test::flightConfig();
  config.vehicle = {0.3, 2.0, 3.0, 1.5};
  config.mapping.update_range_m = 5.0;
  config.mapping.resolution_m = 0.1;
  config.global_planner.clearance_m = 0.5;
  return config;
}

class DevForest : public testing::TestWithParam<int>
{
};

TEST_P(DevForest, IsCrossedWithoutContact)
{
  char name[32];
  std::snprintf(name, sizeof name, "dev_%02d", GetParam());
  const auto file = test::sharedData("forests/random/" + std::string(name) + ".csv");
  if (!exists(file)) GTEST_SKIP() << file;
  const simulation::World world = simulation::World::load(file);
  const FlightOutcome flight = fly(name, test::FlightWorld::of(world), forestConfig(),
                                   {-19.3, 0, 1}, to({19.3, 0, 1}), 90.0);
  EXPECT_GE(flight.min_clearance_m, 0.3);
  EXPECT_TRUE(flight.finite);
  // Every way through the densest one is 57 m long for a clearance of 0.5 m, and a maze for less.
  constexpr int kDensest = 11;
  if (GetParam() != kDensest)
  {
    EXPECT_EQ(flight.status, EngineStatus::GoalReached);
  }
}
INSTANTIATE_TEST_SUITE_P(Random, DevForest, testing::Range(0, 12));

struct Plot
{
  const char *name, *file;
  Eigen::Vector3d start, goal;
};

class RealPlot : public testing::TestWithParam<Plot>
{
};

TEST_P(RealPlot, IsCrossedWithoutContact)
{
  const Plot& plot = GetParam();
  const auto file = test::sharedData(plot.file);
  if (!exists(file)) GTEST_SKIP() << file;
  const simulation::World world = simulation::World::load(file);
  engine::EngineConfig config = forestConfig();
  config.vehicle.max_speed_mps = 1.2;
  config.vehicle.max_acceleration_mps2 = 1.0;
  config.mapping.resolution_m = 0.2;
  const FlightOutcome flight =
      fly(plot.name, test::FlightWorld::of(world), config, plot.start, to(plot.goal), 120.0);
  expectReached(flight, config.vehicle.radius_m);
}
INSTANTIATE_TEST_SUITE_P(Gallery, RealPlot,
                         testing::Values(Plot{"ponderosa_mls_a",
                                              "real/forest_ponderosa_mls/forest_mls_27x26_0.1.bt",
                                              {-12.5, 5.9, 1.5},
                                              {12.5, 10.7, 1.5}},
                                         Plot{"ponderosa_mls_b",
                                              "real/forest_ponderosa_mls/forest_mls_27x26_0.1.bt",
                                              {-12.5, -12.3, 1.5},
                                              {12.5, 4.1, 1.5}},
                                         Plot{"ponderosa_tls",
                                              "real/forest_ponderosa_tls/forest_tls_24x29_0.1.bt",
                                              {-10.9, 9.3, 1.5},
                                              {10.9, 6.9, 1.5}},
                                         Plot{"forest_gen",
                                              "forests/forest_gen/forest0.bt",
                                              {-1.723, -4.168, 1.0},
                                              {3.231, 0.271, 1.0}}),
                         [](const auto& one) { return std::string(one.param.name); });

}  // namespace
}  // namespace slalom
