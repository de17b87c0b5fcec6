// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "AnalyticField.h"
#include "slalom/core/Rng.h"
#include "slalom/global_planner/GlobalPlanner.h"
#include "slalom/global_planner/OccupiedSegments.h"
#include "slalom/spline/WaypointFit.h"

namespace slalom::global_planner
{
namespace
{
using test::AnalyticField;
using test::VerticalCylinder;

constexpr double kRadius = 0.35;

std::shared_ptr<const spline::UniformBSpline> straight(double length)
{
  Eigen::Matrix3Xd ends(3, 2);
  ends << 0, length, 0, 0, 1.5, 1.5;
  return std::make_shared<const spline::UniformBSpline>(
      spline::fitWaypoints(ends, {1.0, 0.8, 0.2}));
}

std::shared_ptr<AnalyticField> forest(core::Rng& rng, int trees, double length)
{
  std::vector<test::Obstacle> obstacles;
  while (static_cast<int>(obstacles.size()) < trees)
  {
    const Eigen::Vector2d centre(rng.uniform(1.5, length - 1.5), rng.uniform(-5, 5));
    const double radius = rng.uniform(0.2, 0.5);
    // Both ends of the mission stay free.
    if (centre.norm() > radius + 1.5 && (centre - Eigen::Vector2d(length, 0)).norm() > radius + 1.5)
      obstacles.push_back(VerticalCylinder{centre, radius});
  }
  return std::make_shared<AnalyticField>(
      obstacles,
      Eigen::AlignedBox3d(Eigen::Vector3d(-8, -8, 0), Eigen::Vector3d(length + 8, 8, 5)));
}

GlobalPlannerInput inputAt(const std::shared_ptr<const spline::UniformBSpline>& r,
                           std::shared_ptr<const core::DistanceField> field, double progress = 0.0)
{
  GlobalPlannerInput input;
  input.reference = r;
  input.field = std::move(field);
  input.progress = progress;
  input.state.p_L = r->position(progress);
  input.state.v_W = r->velocity(progress);
  return input;
}

double denseClearance(const spline::UniformBSpline& curve, double from, double to,
                      const AnalyticField& field)
{
  double nearest = 1e9;
  for (int i = 0; i <= 2000; ++i)
    nearest =
        std::min(nearest, field.signedDistance(curve.position(from + (to - from) * i / 2000.0)));
  return nearest;
}

TEST(GlobalPlanner, WhatItCallsRefinedIsClear)
{
  const GlobalPlanner planner({}, {});
  int refined = 0, failed = 0;
  for (std::uint64_t seed = 0; seed < 60; ++seed)
  {
    SCOPED_TRACE(seed);
    core::Rng rng(seed);
    const auto r = straight(12.0);
    const auto field = forest(rng, 14, 12.0);
    const GlobalPlannerOutput output = planner.step(inputAt(r, field));
    ASSERT_TRUE(output.refined);
    // From where the window may change to where the plan says it is clear.
    EXPECT_GE(denseClearance(output.refined->spline, 0.2, output.refined->clear_until, *field),
              kRadius);
    if (output.outcome == RefineOutcome::Refined || output.outcome == RefineOutcome::Recovered)
      ++refined;
    if (output.outcome == RefineOutcome::GuideFailed ||
        output.outcome == RefineOutcome::StillOccupied)
    {
      ++failed;
      EXPECT_LE(output.refined->stop_at, output.refined->clear_until);
    }
  }
  EXPECT_GE(refined, 30);
  EXPECT_LE(failed, 6) << "of 60 forests with 14 trees on 120 m2";
}

TEST(GlobalPlanner, KeepsTheStartOfItsPreviousPlan)
{
  const GlobalPlanner planner({}, {});
  const auto r = straight(12.0);
  core::Rng rng(7);
  const auto field = forest(rng, 14, 12.0);
  GlobalPlannerInput input = inputAt(r, field);
  std::shared_ptr<const RefinedReference> previous;
  for (double progress = 0.0; progress < 8.0; progress += 0.1)
  {
    input.progress = progress;
    input.previous = previous;
    if (previous) input.state.p_L = previous->spline.position(progress);
    const auto next = planner.step(input).refined;
    if (previous)
    {
      EXPECT_LT((next->spline.position(progress) - previous->spline.position(progress)).norm(),
                1e-12);
      EXPECT_LT((next->spline.velocity(progress) - previous->spline.velocity(progress)).norm(),
                1e-10);
      EXPECT_LT(
          (next->spline.acceleration(progress) - previous->spline.acceleration(progress)).norm(),
          1e-9);
    }
    previous = next;
  }
}

TEST(GlobalPlanner, ReturnsToTheReferenceBehindTheObstacle)
{
  GlobalPlannerConfig config;
  config.horizon_m = 14.0;
  const GlobalPlanner planner(config, {});
  const auto r = straight(14.0);
  const auto field = std::make_shared<AnalyticField>(
      std::vector<test::Obstacle>{VerticalCylinder{{5.0, 0.1}, 0.4}});
  const GlobalPlannerOutput output = planner.step(inputAt(r, field));
  EXPECT_EQ(output.outcome, RefineOutcome::Refined);
  const double late = r->end() - 3.0;
  EXPECT_LT((output.refined->spline.position(late) - r->position(late)).norm(), 0.15);
  EXPECT_LT((output.refined->spline.position(r->end()) - r->position(r->end())).norm(), 1e-9);
  EXPECT_GE(denseClearance(output.refined->spline, 0.0, r->end(), *field), 0.6)
      << "D_z = 0.8 m is kept nearly, there is room";
}

TEST(GlobalPlanner, DoesNotDriftInFreeSpace)
{
  const GlobalPlanner planner({}, {});
  const auto r = straight(12.0);
  const auto field = std::make_shared<AnalyticField>(std::vector<test::Obstacle>{});
  GlobalPlannerInput input = inputAt(r, field, 3.0);
  std::shared_ptr<const RefinedReference> previous;
  for (int k = 0; k < 100; ++k)
  {
    input.previous = previous;
    const GlobalPlannerOutput output = planner.step(input);
    EXPECT_EQ(output.outcome, RefineOutcome::Clear);
    previous = output.refined;
  }
  for (double t = r->start(); t <= r->end(); t += 0.05)
    EXPECT_LT((previous->spline.position(t) - r->position(t)).norm(), 1e-3) << t;
}

TEST(GlobalPlanner, StopsBeforeAWallWithoutAGap)
{
  const GlobalPlanner planner({}, {});
  const auto r = straight(12.0);
  // A closed wall across the whole map, ceiling included.
  const auto field = std::make_shared<AnalyticField>(
      std::vector<test::Obstacle>{
          Eigen::AlignedBox3d(Eigen::Vector3d(5, -50, -50), Eigen::Vector3d(5.4, 50, 50))},
      Eigen::AlignedBox3d(Eigen::Vector3d(-8, -8, 0), Eigen::Vector3d(20, 8, 5)));
  const GlobalPlannerOutput output = planner.step(inputAt(r, field));
  EXPECT_EQ(output.outcome, RefineOutcome::GuideFailed);
  EXPECT_LE(output.refined->spline.position(output.refined->stop_at).x(), 5.0 - kRadius);
  EXPECT_NE(output.record.outcome.find("no way around"), std::string::npos)
      << output.record.outcome;
}

TEST(GlobalPlanner, FindsTheGapInAWall)
{
  const GlobalPlanner planner({}, {});
  const auto r = straight(12.0);
  const auto field = std::make_shared<AnalyticField>(
      std::vector<test::Obstacle>{
          Eigen::AlignedBox3d(Eigen::Vector3d(5, -50, -50), Eigen::Vector3d(5.4, 2.0, 50)),
          Eigen::AlignedBox3d(Eigen::Vector3d(5, 4.2, -50), Eigen::Vector3d(5.4, 50, 50))},
      Eigen::AlignedBox3d(Eigen::Vector3d(-8, -8, 0), Eigen::Vector3d(20, 8, 5)));
  GlobalPlannerConfig config;
  config.horizon_m = 12.0;
  const GlobalPlannerOutput output = GlobalPlanner(config, {}).step(inputAt(r, field));
  EXPECT_EQ(output.outcome, RefineOutcome::Refined) << output.record.outcome;
  EXPECT_GE(denseClearance(output.refined->spline, 0.2, output.refined->clear_until, *field),
            kRadius);
}

TEST(GlobalPlanner, ReportsAGoalInsideAnObstacle)
{
  GlobalPlannerConfig config;
  config.horizon_m = 14.0;
  const GlobalPlanner planner(config, {});
  const auto r = straight(12.0);
  const auto field = std::make_shared<AnalyticField>(
      std::vector<test::Obstacle>{VerticalCylinder{{12.0, 0.0}, 0.75}});
  const GlobalPlannerOutput output = planner.step(inputAt(r, field));
  EXPECT_EQ(output.outcome, RefineOutcome::GoalBlocked);
  EXPECT_LT(output.refined->stop_at, r->end());
  const Eigen::Vector3d stop = output.refined->spline.position(output.refined->stop_at);
  EXPECT_GE(field->signedDistance(stop), kRadius);
  EXPECT_LE(field->signedDistance(stop), kRadius + 0.6) << "stops where it must, not earlier";
}

TEST(GlobalPlanner, SaysThatItHasNoMap)
{
  const auto r = straight(5.0);
  const GlobalPlannerOutput output = GlobalPlanner({}, {}).step(inputAt(r, nullptr));
  EXPECT_EQ(output.outcome, RefineOutcome::NoField);
  EXPECT_EQ(output.refined->clear_until, r->start()) << "nothing is known to be clear";
}

TEST(GlobalPlanner, IsAFunctionOfItsInput)
{
  core::Rng rng(3);
  const auto r = straight(12.0);
  const auto field = forest(rng, 14, 12.0);
  GlobalPlannerConfig one, four;
  one.threads = 1;
  four.threads = 4;
  const auto a = GlobalPlanner(one, {}).step(inputAt(r, field));
  const auto b = GlobalPlanner(four, {}).step(inputAt(r, field));
  EXPECT_EQ(a.refined->spline.controlPoints(), b.refined->spline.controlPoints());
}

TEST(GlobalPlanner, RefusesContradictions)
{
  GlobalPlannerConfig config;
  config.clearance_m = 0.3;
  EXPECT_THROW(GlobalPlanner(config, {}), std::invalid_argument);
}

}  // namespace
}  // namespace slalom::global_planner
