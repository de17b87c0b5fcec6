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
using spline::UniformBSpline;
using test::AnalyticField;
using test::VerticalCylinder;

constexpr double kRadius = 0.35;
constexpr core::Vehicle kVehicle{kRadius, 1.0, 0.8, 1.0};

using Reference = std::shared_ptr<const UniformBSpline>;

Reference straight(double length)
{
  Eigen::Matrix3Xd ends(3, 2);
  ends << 0, length, 0, 0, 1.5, 1.5;
  return std::make_shared<const UniformBSpline>(spline::fitWaypoints(ends, {1.0, 0.8, 0.2}));
}

Reference winding()
{
  Eigen::Matrix3Xd points(3, 6);
  points << 0, 3, 6, 6, 3, 8, 0, 1, 0, 3, 5, 7, 1.5, 1.5, 1.8, 1.5, 1.5, 1.5;
  return std::make_shared<const UniformBSpline>(spline::fitWaypoints(points, {1.0, 0.8, 0.2}));
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

std::shared_ptr<AnalyticField> wallAcross(double x,
                                          const std::vector<std::pair<double, double>>& gaps)
{
  std::vector<test::Obstacle> parts;
  double from = -50.0;
  for (const auto& [lower, upper] : gaps)
  {
    parts.push_back(
        Eigen::AlignedBox3d(Eigen::Vector3d(x, from, -50), Eigen::Vector3d(x + 0.4, lower, 50)));
    from = upper;
  }
  parts.push_back(
      Eigen::AlignedBox3d(Eigen::Vector3d(x, from, -50), Eigen::Vector3d(x + 0.4, 50, 50)));
  return std::make_shared<AnalyticField>(
      parts, Eigen::AlignedBox3d(Eigen::Vector3d(-8, -8, 0), Eigen::Vector3d(20, 8, 5)));
}

GlobalPlannerInput inputAt(const Reference& r, std::shared_ptr<const core::DistanceField> field,
                           double progress = 0.0)
{
  GlobalPlannerInput input;
  input.reference = r;
  input.field = std::move(field);
  input.progress = progress;
  input.state.p_L = r->position(progress);
  input.state.v_W = r->velocity(progress);
  return input;
}

GlobalPlannerConfig longHorizon()
{
  GlobalPlannerConfig config;
  config.horizon_m = 14.0;
  return config;
}

double denseClearance(const UniformBSpline& curve, double from, double to,
                      const AnalyticField& field)
{
  double nearest = 1e9;
  for (int i = 0; i <= 2000; ++i)
    nearest =
        std::min(nearest, field.signedDistance(curve.position(from + (to - from) * i / 2000.0)));
  return nearest;
}

bool gaveAWayUp(RefineOutcome outcome)
{
  return outcome == RefineOutcome::GuideFailed || outcome == RefineOutcome::StillOccupied;
}

TEST(GlobalPlanner, WhatItPromisesIsClear)
{
  const GlobalPlanner planner({}, kVehicle);
  int refined = 0, failed = 0;
  for (std::uint64_t seed = 0; seed < 60; ++seed)
  {
    SCOPED_TRACE(seed);
    core::Rng rng(seed);
    const auto r = straight(12.0);
    const auto field = forest(rng, 14, 12.0);
    const GlobalPlannerOutput output = planner.step(inputAt(r, field));
    ASSERT_TRUE(output.refined);
    const RefinedReference& plan = *output.refined;
    EXPECT_GE(denseClearance(plan.spline, 0.0, plan.clear_until, *field), kRadius - 1e-3);
    EXPECT_LE(plan.stop_at, plan.clear_until);
    EXPECT_EQ(plan.law.to(), plan.stop_at);
    EXPECT_EQ(plan.along.size(), plan.spline.size());
    EXPECT_EQ(output.record.certified, !gaveAWayUp(output.outcome));
    if (output.record.certified)
    {
      EXPECT_EQ(plan.clear_until, plan.spline.end());
    }
    refined +=
        output.outcome == RefineOutcome::Refined || output.outcome == RefineOutcome::Recovered;
    failed += gaveAWayUp(output.outcome);
  }
  EXPECT_GE(refined, 30);
  EXPECT_LE(failed, 3) << "of 60 forests with 14 trees on 120 m2";
}

TEST(GlobalPlanner, KeepsLimitsEverywhere)
{
  const GlobalPlanner planner({}, kVehicle);
  for (std::uint64_t seed = 0; seed < 60; ++seed)
  {
    SCOPED_TRACE(seed);
    core::Rng rng(seed);
    const auto r = straight(12.0);
    const auto field = forest(rng, 14, 12.0);
    const auto plan = planner.step(inputAt(r, field)).refined;
    ASSERT_EQ(plan->law.excess(), 0.0);
    for (double t = plan->law.from(); t < plan->law.to(); t += 0.003)
    {
      const double pace = plan->law.pace(t);
      const Eigen::Vector3d v = pace * plan->spline.velocity(t);
      const Eigen::Vector3d a = pace * pace * plan->spline.acceleration(t) +
                                plan->law.paceChange(t) * plan->spline.velocity(t);
      ASSERT_LE(v.cwiseAbs().maxCoeff(), 1.01 * kVehicle.max_speed_mps) << t;
      ASSERT_LE(a.cwiseAbs().maxCoeff(), 1.01 * kVehicle.max_acceleration_mps2) << t;
    }
    EXPECT_LE((plan->law.pace(plan->stop_at) * plan->spline.velocity(plan->stop_at)).norm(), 1e-3)
        << "rests where it ends";
  }
}

/// Flies plan after plan exactly; every one must continue the one before it.
TEST(GlobalPlanner, ContinuesTheMotionOfItsPreviousPlan)
{
  const GlobalPlanner planner({}, kVehicle);
  for (const std::uint64_t seed : {7, 8, 9})
  {
    SCOPED_TRACE(seed);
    const auto r = straight(12.0);
    core::Rng rng(seed);
    GlobalPlannerInput input = inputAt(r, forest(rng, 14, 12.0));
    for (int k = 0; k < 80; ++k)
    {
      const std::shared_ptr<const RefinedReference> previous = input.previous;
      const auto next = planner.step(input).refined;
      const double t = input.progress;
      if (previous)
      {
        EXPECT_LT((next->spline.position(t) - previous->spline.position(t)).norm(), 1e-12);
        EXPECT_LT((next->spline.velocity(t) - previous->spline.velocity(t)).norm(), 1e-10);
        EXPECT_LT((next->spline.acceleration(t) - previous->spline.acceleration(t)).norm(), 1e-9);
        EXPECT_NEAR(next->referenceTime(t), previous->referenceTime(t), 1e-9);
        EXPECT_NEAR(next->law.pace(t), previous->law.pace(t), 1e-3);
      }
      input.previous = next;
      input.progress = next->law.advance(t, 0.1);
      input.pace = next->law.pace(input.progress);
      input.state.p_L = next->spline.position(input.progress);
      input.state.v_W = input.pace * next->spline.velocity(input.progress);
    }
    EXPECT_GT(input.previous->referenceTime(input.progress), 5.0) << "it gets on";
  }
}

TEST(GlobalPlanner, WindowDoesNotGrowWithTheFlight)
{
  const GlobalPlanner planner({}, kVehicle);
  const auto r = straight(300.0);
  const auto field = std::make_shared<AnalyticField>(
      std::vector<test::Obstacle>{},
      Eigen::AlignedBox3d(Eigen::Vector3d(-8, -8, 0), Eigen::Vector3d(308, 8, 5)));
  GlobalPlannerInput input = inputAt(r, field);
  Eigen::Index most = 0;
  for (double progress = 0.0; progress < 250.0; progress += 2.0)
  {
    input.progress = progress;
    input.state.p_L = r->position(progress);
    input.state.v_W = r->velocity(progress);
    const auto next = planner.step(input).refined;
    most = std::max(most, next->spline.size());
    input.previous = next;
  }
  EXPECT_LE(most, 70) << "control points; 8 m at 1 m/s and 0.2 s are 40";
}

TEST(GlobalPlanner, ReturnsToTheReferenceBehindTheObstacle)
{
  const auto r = straight(14.0);
  const auto field = std::make_shared<AnalyticField>(
      std::vector<test::Obstacle>{VerticalCylinder{{5.0, 0.1}, 0.4}});
  const GlobalPlannerOutput output = GlobalPlanner(longHorizon(), kVehicle).step(inputAt(r, field));
  EXPECT_EQ(output.outcome, RefineOutcome::Refined);
  const UniformBSpline& curve = output.refined->spline;
  for (double t = curve.end() - 3.0; t <= curve.end(); t += 0.1)
  {
    const double on_r = r->project(curve.position(t), r->start(), r->end());
    EXPECT_LT((curve.position(t) - r->position(on_r)).norm(), 0.05) << t;
  }
  EXPECT_LT((curve.position(curve.end()) - r->position(r->end())).norm(), 1e-9);
  EXPECT_GE(denseClearance(curve, 0.0, curve.end(), *field), 0.6)
      << "D_z = 0.8 m is kept nearly, there is room";
}

TEST(GlobalPlanner, ReturnsLateWhereOnlyTheGoalCounts)
{
  const auto r = straight(30.0);
  const auto field = std::make_shared<AnalyticField>(std::vector<test::Obstacle>{});
  const auto planned = [&](ReturnPolicy policy, bool only_goal)
  {
    GlobalPlannerConfig config = longHorizon();
    config.return_to_reference = policy;
    GlobalPlannerInput input = inputAt(r, field);
    input.only_goal = only_goal;
    input.state.p_L.y() = 2.5;  // was led there by an obstacle
    for (int k = 0; k < 9; ++k)
      input.previous = GlobalPlanner(config, kVehicle).step(input).refined;
    return input.previous->spline;
  };
  const auto offAt = [](const UniformBSpline& curve, double x) {
    return curve.position(curve.project({x, 1, 1.5}, curve.start(), curve.end())).y();
  };
  const UniformBSpline soon = planned(ReturnPolicy::Soon, true);
  const UniformBSpline late = planned(ReturnPolicy::Late, false);
  EXPECT_LT(offAt(soon, 7.0), 0.2);
  EXPECT_GT(offAt(late, 7.0), 0.8) << "on the straight way to the window's end";
  EXPECT_LT(late.length(late.start(), late.end()), soon.length(soon.start(), soon.end()));
  EXPECT_LT(offAt(late, 14.0), 0.05);
  EXPECT_EQ(planned(ReturnPolicy::Auto, true).controlPoints(), late.controlPoints());
  EXPECT_EQ(planned(ReturnPolicy::Auto, false).controlPoints(), soon.controlPoints());
}

TEST(GlobalPlanner, AVehicleThatStandsWithinItsMarginFindsAWayOut)
{
  // A corridor that leaves more than the radius, and less than the margin besides.
  const auto wall = [](double y0, double y1)
  { return Eigen::AlignedBox3d(Eigen::Vector3d(-3, y0, -50), Eigen::Vector3d(2, y1, 50)); };
  constexpr double kHalf = kRadius + 0.045;
  const auto field = std::make_shared<AnalyticField>(
      std::vector<test::Obstacle>{wall(kHalf, kHalf + 0.4), wall(-kHalf - 0.4, -kHalf)});
  GlobalPlannerInput input = inputAt(straight(14.0), field);
  input.state.v_W.setZero();
  const GlobalPlannerOutput output = GlobalPlanner({}, kVehicle).step(input);
  ASSERT_TRUE(output.record.certified) << output.record.reason;
  const RefinedReference& plan = *output.refined;
  EXPECT_GT(plan.spline.position(plan.stop_at).x(), 4.0);
  EXPECT_GE(denseClearance(plan.spline, 0.0, plan.clear_until, *field), kRadius - 1e-3);
}

/// A tracker tracks: where R is free the plan is R, curves included, however often it is refined.
TEST(GlobalPlanner, DoesNotDriftInFreeSpace)
{
  const GlobalPlanner planner({}, kVehicle);
  const auto field = std::make_shared<AnalyticField>(std::vector<test::Obstacle>{});
  for (const Reference& r : {straight(12.0), winding()})
  {
    GlobalPlannerInput input = inputAt(r, field, 3.0);
    for (int k = 0; k < 100; ++k)
    {
      const GlobalPlannerOutput output = planner.step(input);
      ASSERT_EQ(output.outcome, RefineOutcome::Clear);
      input.previous = output.refined;
    }
    const UniformBSpline& curve = input.previous->spline;
    for (double t = curve.start(); t <= curve.end(); t += 0.05)
      EXPECT_LT((curve.position(t) - r->position(t)).norm(), 1e-3) << t;
  }
}

TEST(GlobalPlanner, StopsBeforeAWallWithoutAGap)
{
  const auto field = wallAcross(5.0, {});
  const GlobalPlannerOutput output =
      GlobalPlanner({}, kVehicle).step(inputAt(straight(30.0), field));
  EXPECT_TRUE(output.record.certified || gaveAWayUp(output.outcome));
  const Eigen::Vector3d stop = output.refined->spline.position(output.refined->stop_at);
  EXPECT_LE(stop.x(), 5.0 - kRadius);
  EXPECT_GE(stop.x(), 3.0) << "as near as it can be";
}

TEST(GlobalPlanner, TakesTheNearerOfTwoGaps)
{
  for (const double side : {1.0, -1.0})
  {
    SCOPED_TRACE(side);
    const auto r = straight(12.0);
    const auto field = side > 0 ? wallAcross(5.0, {{-5.2, -3.0}, {1.0, 3.2}})
                                : wallAcross(5.0, {{-3.2, -1.0}, {3.0, 5.2}});
    const GlobalPlannerOutput output =
        GlobalPlanner(longHorizon(), kVehicle).step(inputAt(r, field));
    ASSERT_EQ(output.outcome, RefineOutcome::Refined) << output.record.reason;
    const UniformBSpline& curve = output.refined->spline;
    EXPECT_GE(denseClearance(curve, 0.0, curve.end(), *field), kRadius - 1e-3);
    for (double t = curve.start(); t <= curve.end(); t += 0.05)
      if (const Eigen::Vector3d p = curve.position(t); p.x() > 5.0 && p.x() < 5.4)
      {
        EXPECT_GT(side * p.y(), 0.0) << "through the gap at " << 2.1 * side;
      }
  }
}

TEST(GlobalPlanner, LeavesAUTrap)
{
  // R runs into a pocket 4 m deep; the plan must turn back and go around it.
  const auto r = straight(14.0);
  const auto box = [](double x0, double y0, double x1, double y1)
  { return Eigen::AlignedBox3d(Eigen::Vector3d(x0, y0, -50), Eigen::Vector3d(x1, y1, 50)); };
  const auto field = std::make_shared<AnalyticField>(
      std::vector<test::Obstacle>{box(7.6, -2, 8.0, 2), box(4, 1.6, 8, 2), box(4, -2, 8, -1.6)},
      Eigen::AlignedBox3d(Eigen::Vector3d(-8, -8, 0), Eigen::Vector3d(20, 8, 5)));
  const GlobalPlannerOutput output =
      GlobalPlanner(longHorizon(), kVehicle).step(inputAt(r, field, 7.0));
  ASSERT_EQ(output.outcome, RefineOutcome::Refined) << output.record.reason;
  const UniformBSpline& curve = output.refined->spline;
  EXPECT_GE(denseClearance(curve, 7.0, curve.end(), *field), kRadius - 1e-3);
  EXPECT_LT((curve.position(curve.end()) - r->position(r->end())).norm(), 1e-9);
  EXPECT_GT(curve.size(), r->size()) << "the way is longer than R: it has more control points";
}

struct BlockedGoal : testing::Test
{
  Reference r = straight(12.0);
  std::shared_ptr<AnalyticField> field = std::make_shared<AnalyticField>(
      std::vector<test::Obstacle>{VerticalCylinder{{12.0, 0.0}, 0.75}});
  GlobalPlannerConfig config = longHorizon();
};

TEST_F(BlockedGoal, IsApproachedAndReported)
{
  const GlobalPlannerOutput output = GlobalPlanner(config, kVehicle).step(inputAt(r, field));
  EXPECT_EQ(output.outcome, RefineOutcome::GoalBlocked);
  EXPECT_EQ(output.goal.state, GoalState::Occupied);
  const RefinedReference& plan = *output.refined;
  const Eigen::Vector3d stop = plan.spline.position(plan.stop_at);
  EXPECT_GE(field->signedDistance(stop), kRadius);
  EXPECT_LE(field->signedDistance(stop), kRadius + 0.6) << "stops where it must, not earlier";
  EXPECT_NEAR(output.goal.short_m, (stop - r->position(r->end())).norm(), 1e-9);
}

TEST_F(BlockedGoal, EndsTheMissionWhereTheVehicleIsWhenAskedTo)
{
  config.goal_policy = GoalPolicy::Reject;
  const GlobalPlannerOutput output = GlobalPlanner(config, kVehicle).step(inputAt(r, field));
  EXPECT_EQ(output.outcome, RefineOutcome::GoalBlocked);
  EXPECT_NE(output.record.reason.find("rejected"), std::string::npos);
}

TEST_F(BlockedGoal, ThatIsOnlyWalledInIsUnreachable)
{
  const auto box = [](double x0, double y0, double x1, double y1)
  { return Eigen::AlignedBox3d(Eigen::Vector3d(x0, y0, -50), Eigen::Vector3d(x1, y1, 50)); };
  field = std::make_shared<AnalyticField>(
      std::vector<test::Obstacle>{box(10, -2, 10.4, 2), box(14, -2, 14.4, 2),
                                  box(10, 1.8, 14.4, 2.2), box(10, -2.2, 14.4, -1.8)},
      Eigen::AlignedBox3d(Eigen::Vector3d(-8, -8, 0), Eigen::Vector3d(20, 8, 5)));
  const GlobalPlannerOutput output = GlobalPlanner(config, kVehicle).step(inputAt(r, field));
  EXPECT_EQ(output.outcome, RefineOutcome::GoalBlocked) << output.record.reason;
  EXPECT_EQ(output.goal.state, GoalState::Unreachable);
  EXPECT_GT(output.goal.short_m, 1.5) << "a walled goal is not near";
  EXPECT_GE(denseClearance(output.refined->spline, 0.0, output.refined->clear_until, *field),
            kRadius - 1e-3);
}

/// A field whose space beyond a plane was never seen.
class HalfSeen : public AnalyticField
{
 public:
  explicit HalfSeen(double seen_until_x) : AnalyticField({}), until_(seen_until_x) {}
  core::Occupancy occupancy(const Eigen::Vector3d& p) const override
  {
    return p.x() > until_ ? core::Occupancy::Unknown : AnalyticField::occupancy(p);
  }
  std::optional<core::DistanceSample> sample(const Eigen::Vector3d& p,
                                             core::UnknownAs unknown) const override
  {
    auto here = AnalyticField::sample(p, unknown);
    if (here && unknown == core::UnknownAs::Occupied)
      here->distance = std::min(here->distance, until_ - p.x());
    return here;
  }
  std::optional<double> lowerBound(const Eigen::Vector3d& p, core::UnknownAs unknown) const override
  {
    const auto bound = AnalyticField::lowerBound(p, unknown);
    return bound && unknown == core::UnknownAs::Occupied ? std::min(*bound, until_ - p.x()) : bound;
  }

 private:
  double until_;
};

TEST(GlobalPlanner, RestsBeforeUnknownSpace)
{
  const auto r = straight(12.0);
  const auto field = std::make_shared<HalfSeen>(5.0);
  const auto plan = GlobalPlanner({}, kVehicle).step(inputAt(r, field)).refined;
  EXPECT_EQ(plan->clear_until, plan->spline.end()) << "unknown space is no known obstacle";
  EXPECT_NEAR(plan->spline.position(plan->stop_at).x(), 5.0 - kRadius, 0.01);
  EXPECT_LE((plan->law.pace(plan->stop_at) * plan->spline.velocity(plan->stop_at)).norm(), 1e-3);

  GlobalPlannerConfig daring;
  daring.unknown = UnknownPolicy::Free;
  const auto dared = GlobalPlanner(daring, kVehicle).step(inputAt(r, field)).refined;
  EXPECT_EQ(dared->stop_at, dared->clear_until);
}

TEST(GlobalPlanner, FliesSlowlyWhereItJustFits)
{
  const auto r = straight(14.0);
  const auto corridor = [](double half_width)
  {
    const auto wall = [](double y0, double y1)
    { return Eigen::AlignedBox3d(Eigen::Vector3d(4, y0, -50), Eigen::Vector3d(9, y1, 50)); };
    return std::make_shared<AnalyticField>(std::vector<test::Obstacle>{
        wall(half_width, half_width + 0.4), wall(-half_width - 0.4, -half_width)});
  };
  const auto speedInside = [&](double half_width)
  {
    const auto plan =
        GlobalPlanner(longHorizon(), kVehicle).step(inputAt(r, corridor(half_width))).refined;
    const double t = plan->spline.project({6.5, 0, 1.5}, plan->spline.start(), plan->spline.end());
    return plan->law.pace(t) * plan->spline.velocity(t).norm();
  };
  EXPECT_LT(speedInside(0.46), 0.96);
  EXPECT_LT(speedInside(0.45), speedInside(0.46) - 0.02);
  EXPECT_GT(speedInside(1.5), 0.95);
}

TEST(GlobalPlanner, StartsAnewWhereTheVehicleIs)
{
  const GlobalPlanner planner({}, kVehicle);
  const auto r = straight(14.0);
  const auto field = std::make_shared<AnalyticField>(
      std::vector<test::Obstacle>{VerticalCylinder{{5.0, 1.0}, 0.4}});
  GlobalPlannerInput input = inputAt(r, field, 2.0);
  input.previous = planner.step(input).refined;
  input.progress = 3.0;
  input.state.p_L = Eigen::Vector3d(2.0, 2.5, 1.6);  // far from the plan: blown away
  input.state.v_W = Eigen::Vector3d(0.2, 0.6, 0.0);
  const GlobalPlannerOutput output = planner.step(input);
  ASSERT_TRUE(output.record.certified) << output.record.reason;
  const RefinedReference& plan = *output.refined;
  EXPECT_LT((plan.spline.position(input.progress) - input.state.p_L).norm(), 1e-9);
  EXPECT_LT((plan.spline.velocity(input.progress) - input.state.v_W).norm(), 1e-9);
  EXPECT_GE(denseClearance(plan.spline, input.progress, plan.clear_until, *field), kRadius - 1e-3);
}

TEST(GlobalPlanner, HoldsItsGoalForAnyNumberOfPlans)
{
  const GlobalPlanner planner({}, kVehicle);
  const auto r = straight(4.0);
  GlobalPlannerInput input =
      inputAt(r, std::make_shared<AnalyticField>(std::vector<test::Obstacle>{}));
  for (int k = 0; k < 120; ++k)
  {
    const auto plan = planner.step(input).refined;
    input.previous = plan;
    input.progress = plan->law.advance(input.progress, 0.1);
    input.pace = plan->law.pace(input.progress);
    input.state.p_L = plan->spline.position(input.progress);
    input.state.v_W = input.pace * plan->spline.velocity(input.progress);
  }
  EXPECT_LT((input.state.p_L - r->position(r->end())).norm(), 1e-3);
}

/// The end of R leaves the map, and what is left of it ends before the wall that a plan goes
/// around: the plan must not be cut off under the vehicle.
TEST(GlobalPlanner, IsNotCutOffWhenTheWindowShrinks)
{
  const GlobalPlanner planner({}, kVehicle);
  const auto r = straight(12.0);
  const Eigen::AlignedBox3d wall(Eigen::Vector3d(6, -3, -50), Eigen::Vector3d(9.5, 1.0, 50));
  const auto seen = [&](double until)
  {
    return std::make_shared<AnalyticField>(
        std::vector<test::Obstacle>{wall},
        Eigen::AlignedBox3d(Eigen::Vector3d(-8, -8, 0), Eigen::Vector3d(until, 8, 5)));
  };
  GlobalPlannerInput input = inputAt(r, seen(20.0));
  const auto moveOn = [&](const std::shared_ptr<const RefinedReference>& plan)
  {
    input.previous = plan;
    input.progress = plan->law.advance(input.progress, 0.1);
    input.pace = plan->law.pace(input.progress);
    input.state.p_L = plan->spline.position(input.progress);
    input.state.v_W = input.pace * plan->spline.velocity(input.progress);
  };
  for (int k = 0; k < 50; ++k) moveOn(planner.step(input).refined);
  ASSERT_GT(input.state.v_W.norm(), 0.5);
  for (const double until : {9.0, 8.0})
  {
    SCOPED_TRACE(until);
    input.field = seen(until);
    const GlobalPlannerOutput output = planner.step(input);
    EXPECT_LE(output.refined->law.excess(), 0.01) << output.record.reason;
    moveOn(output.refined);
  }
}

TEST(GlobalPlanner, SaysThatItHasNoMap)
{
  const GlobalPlannerOutput output =
      GlobalPlanner({}, kVehicle).step(inputAt(straight(5.0), nullptr));
  EXPECT_EQ(output.outcome, RefineOutcome::NoField);
  EXPECT_FALSE(output.refined) << "nothing is known to be clear";
}

TEST(GlobalPlanner, IsAFunctionOfItsInput)
{
  core::Rng rng(3);
  const auto r = straight(12.0);
  const auto field = forest(rng, 14, 12.0);
  GlobalPlannerConfig one, four;
  one.threads = 1;
  four.threads = 4;
  const auto a = GlobalPlanner(one, kVehicle).step(inputAt(r, field));
  const auto b = GlobalPlanner(four, kVehicle).step(inputAt(r, field));
  EXPECT_EQ(a.refined->spline.controlPoints(), b.refined->spline.controlPoints());
  EXPECT_EQ(a.refined->law.duration(), b.refined->law.duration());
}

TEST(GlobalPlanner, RefusesContradictions)
{
  GlobalPlannerConfig config;
  config.clearance_m = 0.3;
  EXPECT_THROW(GlobalPlanner(config, {}), std::invalid_argument);
}

}  // namespace
}  // namespace slalom::global_planner
