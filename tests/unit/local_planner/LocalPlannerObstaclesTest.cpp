// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "ClosedLoop.h"
#include "slalom/core/Rng.h"
#include "slalom/local_planner/LocalPlanner.h"

namespace
{
using Eigen::Vector3d;
using slalom::core::Rng;
using slalom::core::Vehicle;
using namespace slalom::local_planner;
using slalom::test::AnalyticField;
using slalom::test::ClosedLoop;
using slalom::test::fieldOf;
using slalom::test::Obstacle;
using slalom::test::Sphere;
using slalom::test::straightReference;
using slalom::test::VerticalCylinder;

constexpr double kRadius = 0.35, kAsked = 0.45;

struct Flown
{
  double min_clearance = 1e9;
  double end_x = 0.0;
  int fresh = 0, ticks = 0;
};

Flown flyAlongX(std::vector<Obstacle> obstacles, double speed, double lead)
{
  ClosedLoop loop(straightReference(Vector3d(0, 0, 1.5), Vector3d(speed, 0, 0), 9.0 / speed),
                  fieldOf(std::move(obstacles)));
  loop.lead = lead;
  Flown flown;
  loop.fly(11.0 / speed,
           [&](const auto& output)
           {
             flown.min_clearance = std::min(flown.min_clearance, loop.clearance());
             flown.fresh += output.fallback == Fallback::None;
             ++flown.ticks;
           });
  flown.end_x = loop.state.p_L.x();
  return flown;
}

TEST(LocalPlannerObstacles, ClearanceIsKeptBesideAndOnThePath)
{
  // The reference runs ahead without waiting in every second case.
  for (std::uint64_t seed = 1; seed <= 12; ++seed)
  {
    SCOPED_TRACE(seed);
    Rng rng(seed);
    std::vector<Obstacle> obstacles;
    const double y = rng.uniform(-0.8, 0.8), r = rng.uniform(0.1, 0.6);
    if (seed % 3 == 0)
      obstacles.push_back(Sphere{Vector3d(6.0, y, rng.uniform(1.2, 1.8)), r});
    else if (seed % 3 == 1)
      obstacles.push_back(VerticalCylinder{{6.0, y}, r});
    else
      obstacles.push_back(Eigen::AlignedBox3d(Vector3d(6.0, y, -5), Vector3d(7.0, y + 2 * r, 9)));
    const Flown flown = flyAlongX(obstacles, rng.uniform(0.6, 1.2), seed % 2 ? 1.0 : 100.0);
    EXPECT_GE(flown.min_clearance, kAsked - 0.05);
    EXPECT_GE(flown.fresh, flown.ticks - 3);
  }
}

TEST(LocalPlannerObstacles, AWallStopsTheVehicle)
{
  const Flown flown =
      flyAlongX({Eigen::AlignedBox3d(Vector3d(6, -30, -30), Vector3d(6.5, 30, 30))}, 1.2, 100.0);
  EXPECT_GE(flown.min_clearance, kAsked - 0.02);
  EXPECT_NEAR(flown.end_x, 6.0 - kAsked, 0.05);
}

TEST(LocalPlannerObstacles, AGapIsFlownThroughInItsMiddle)
{
  // Each side of the gap is 0.4 m away: less than asked for, more than the vehicle needs.
  const Flown flown = flyAlongX(
      {VerticalCylinder{{6.0, 0.75}, 0.3}, VerticalCylinder{{6.0, -0.65}, 0.3}}, 0.8, 1.0);
  EXPECT_GE(flown.min_clearance, kRadius);
  EXPECT_GT(flown.end_x, 8.0);
}

TEST(LocalPlannerObstacles, APlanOnTheOtherSideOfATrunkIsGivenUp)
{
  // The reference changes sides while the vehicle stands before the trunk with a plan for the
  // first.
  const auto pastTheTrunk = [](double side)
  {
    Eigen::Matrix3Xd points(3, 60);
    for (Eigen::Index i = 0; i < points.cols(); ++i)
    {
      const double x = 0.16 * static_cast<double>(i);
      points.col(i) << x, side * 1.1 * std::exp(-std::pow((x - 3.0) / 1.3, 2)), 1.0;
    }
    return std::make_shared<slalom::spline::UniformBSpline>(points, 0.2);
  };
  for (const double side : {-1.0, 1.0})
  {
    SCOPED_TRACE(side);
    const auto reference = pastTheTrunk(side);
    ClosedLoop loop(reference, fieldOf({VerticalCylinder{{3.0, 0.0}, 0.4}}));
    const Vector3d held(1.9, -0.25 * side, 1.0);
    loop.input.reference = pastTheTrunk(-side);
    for (int k = 0; k < 40; ++k)
    {
      loop.progressTo(2.4);
      loop.state.p_L = held;
      loop.command = {};
      loop.tick();
    }
    loop.input.reference = reference;
    loop.state.p_L = held;
    double least = 1e9;
    loop.fly(12.0, [&](const auto&) { least = std::min(least, loop.clearance()); });
    EXPECT_GT(loop.state.p_L.x(), 5.0);
    EXPECT_GE(least, kAsked - 0.05);
  }
}

TEST(LocalPlannerObstacles, AStartInsideTheMarginOrTheObstacleRecovers)
{
  for (std::uint64_t seed = 1; seed <= 24; ++seed)
  {
    SCOPED_TRACE(seed);
    Rng rng(seed);
    const auto field = fieldOf({VerticalCylinder{{0.0, 0.0}, 0.5}});
    // The reference keeps away from the trunk; the vehicle starts too near or within.
    ClosedLoop loop(straightReference(Vector3d(-2.0, 1.2, 1.0), Vector3d(0.5, 0, 0), 20.0), field);
    loop.progressTo(4.0);
    const double start = rng.uniform(seed % 2 ? 0.5 : 0.1, 0.9);
    const double angle = rng.uniform(0.0, 6.28);
    loop.state.p_L = Vector3d(start * std::cos(angle), start * std::sin(angle), 1.0);
    double before = loop.clearance();
    int deeper = 0;
    loop.fly(3.0,
             [&](const auto& output)
             {
               ASSERT_TRUE(output.command.v_W.allFinite());
               deeper += loop.clearance() < std::min(kRadius, before) - 1e-3;
               before = loop.clearance();
             });
    EXPECT_EQ(deeper, 0);
    EXPECT_GE(loop.clearance(), kAsked - 0.02);
  }
}

TEST(LocalPlannerObstacles, SlackTellsHowFarThePlanEnters)
{
  const auto field = fieldOf({Eigen::AlignedBox3d(Vector3d(-9, 0.25, -9), Vector3d(9, 1, 9))});
  ClosedLoop loop(straightReference(Vector3d(0, 0, 1), Vector3d(0.2, 0, 0), 20.0), field);
  const auto output = loop.tick();
  // 0.25 m from the wall, 0.45 m asked for, and the first stage cannot be elsewhere.
  EXPECT_NEAR(output.worst_obstacle_slack_m, 0.2, 0.02);
  EXPECT_FALSE(output.close_obstacles_L.empty());
  loop.fly(3.0);
  EXPECT_LE(loop.tick().worst_obstacle_slack_m, 1e-3);
}

}  // namespace
