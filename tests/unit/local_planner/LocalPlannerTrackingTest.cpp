// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <numbers>

#include "ClosedLoop.h"
#include "slalom/core/Rng.h"
#include "slalom/local_planner/LocalPlanner.h"
#include "slalom/spline/WaypointFit.h"

namespace
{
using Eigen::Vector3d;
using slalom::core::Rng;
using slalom::core::Vehicle;
using namespace slalom::local_planner;
using slalom::test::ClosedLoop;
using slalom::test::fieldOf;
using slalom::test::straightReference;

TEST(LocalPlannerTracking, NoSteadyErrorOnAStraightLine)
{
  // Without the velocity of the spline as feed-forward the lag is 0.1 m and more (algorithm 4.3).
  for (std::uint64_t seed = 1; seed <= 6; ++seed)
  {
    SCOPED_TRACE(seed);
    Rng rng(seed);
    Vehicle vehicle;
    vehicle.max_speed_mps = 1.5;  // room to catch up
    const double course = rng.uniform(-std::numbers::pi, std::numbers::pi);
    const Vector3d velocity = 1.2 * Vector3d(std::cos(course), std::sin(course), 0.0);
    ClosedLoop loop(straightReference(Vector3d(3, 4, 5), velocity, 30.0), fieldOf({}), {}, vehicle);
    loop.state.p_L += rng.uniform3(-0.3, 0.3);
    loop.yaw = rng.uniform(-std::numbers::pi, std::numbers::pi);
    loop.fly(10.0);
    double worst = 0.0;
    loop.fly(5.0, [&](const auto&) { worst = std::max(worst, loop.trackingError()); });
    EXPECT_LE(worst, 0.02);
    EXPECT_LE((loop.command.v_W - velocity).norm(), 0.01);
    EXPECT_NEAR(slalom::core::wrapAngle(loop.yaw - course), 0.0, 0.02);
  }
}

TEST(LocalPlannerTracking, CurvesAreFollowedClosely)
{
  Eigen::Matrix3Xd waypoints(3, 6);
  waypoints << 0, 4, 8, 8, 4, 0,  //
      0, 1, 0, 5, 6, 5,           //
      1, 1, 2, 2, 1, 1;
  const auto reference = std::make_shared<slalom::spline::UniformBSpline>(
      slalom::spline::fitWaypoints(waypoints, {1.0, 0.8, 0.2}));
  ClosedLoop loop(reference, fieldOf({}));
  double worst = 0.0, sum = 0.0;
  int ticks = 0;
  loop.fly(reference->duration(),
           [&](const auto& output)
           {
             EXPECT_EQ(output.fallback, Fallback::None) << output.reason;
             worst = std::max(worst, loop.trackingError());
             sum += loop.trackingError();
             ++ticks;
           });
  EXPECT_LE(sum / ticks, 0.02);
  EXPECT_LE(worst, 0.08);
}

/// Mean distance to a circle of 2 m at 1.2 m/s of a vehicle whose velocity lags behind the command.
double errorOnCircle(double vehicle_lag_s, double assumed_lag_s)
{
  constexpr double kSpan = 0.2, kRadius = 2.0, kSpeed = 1.2, kStep = 0.005;
  Eigen::Matrix3Xd points(3, 80);
  for (Eigen::Index i = 0; i < points.cols(); ++i)
  {
    const double angle = kSpeed / kRadius * kSpan * static_cast<double>(i - 1);
    points.col(i) = kRadius * Vector3d(std::sin(angle), 1.0 - std::cos(angle), 0.0);
  }
  const auto reference = std::make_shared<const slalom::spline::UniformBSpline>(points, kSpan);
  Vehicle vehicle;
  vehicle.max_speed_mps = 2.0;
  vehicle.velocity_lag_s = assumed_lag_s;
  LocalPlanner planner(LocalPlannerConfig{}, vehicle);
  LocalPlannerInput input;
  input.reference = reference;
  input.law = slalom::test::lawTo(*reference, reference->end());
  input.state.p_L = reference->position(0.0);
  input.state.v_W = reference->velocity(0.0);
  input.last_command.v_W = input.state.v_W;
  double sum = 0.0;
  int ticks = 0;
  for (double t = 0.0; t < 14.0; t += 0.05)
  {
    input.progress = input.state.t = t;
    input.state.q_WB = slalom::core::fromYaw(kSpeed / kRadius * t);
    input.last_command = planner.step(input).command;
    for (double within = 0.0; within < 0.05 - 1e-9; within += kStep)
    {
      input.state.v_W += (input.last_command.v_W - input.state.v_W) * (kStep / vehicle_lag_s);
      input.state.p_L += kStep * input.state.v_W;
    }
    if (t < 4.0) continue;
    sum += std::abs((input.state.p_L - Vector3d(0, kRadius, 0)).norm() - kRadius);
    ++ticks;
  }
  return sum / ticks;
}

TEST(LocalPlannerTracking, KnowsHowTheVehicleLags)
{
  const double blind = errorOnCircle(0.25, 0.0);
  EXPECT_LE(errorOnCircle(0.25, 0.25), 0.6 * blind);
  // A lag that is a fifth off is better than none, either way.
  EXPECT_LE(errorOnCircle(0.25, 0.2), 0.9 * blind);
  EXPECT_LE(errorOnCircle(0.25, 0.3), 0.9 * blind);
}

TEST(LocalPlannerTracking, RestsAtTheStop)
{
  const auto reference = straightReference(Vector3d(0, 0, 1), Vector3d(1.0, 0.4, 0.0), 20.0);
  ClosedLoop loop(reference, fieldOf({}));
  loop.input.law = slalom::test::lawTo(*reference, 6.0);
  loop.fly(12.0);
  const Vector3d stop = reference->position(6.0);
  const double course = std::atan2(0.4, 1.0);
  loop.fly(3.0,
           [&](const auto& output)
           {
             EXPECT_LE((loop.state.p_L - stop).norm(), 0.02);
             EXPECT_LE(output.command.v_W.norm(), 0.01);
             EXPECT_NEAR(loop.yaw, course, 0.05);  // holds its last heading
           });
}

TEST(LocalPlannerTracking, YawTurnsTheShortWayAcrossPi)
{
  for (const double side : {1.0, -1.0})
  {
    SCOPED_TRACE(side);
    const double course = side * (std::numbers::pi - 0.3);
    ClosedLoop loop(straightReference(Vector3d::Zero(),
                                      Vector3d(std::cos(course), std::sin(course), 0.0), 20.0),
                    fieldOf({}));
    loop.yaw = -side * (std::numbers::pi - 0.3);  // 0.6 rad away through pi, 5.7 rad the long way
    loop.fly(6.0);
    EXPECT_NEAR(slalom::core::wrapAngle(loop.yaw - course), 0.0, 0.02);
    EXPECT_LE(loop.turned, 0.75);
  }
}

TEST(LocalPlannerTracking, PaceIsHonoured)
{
  const auto reference = straightReference(Vector3d::Zero(), Vector3d(1.0, 0, 0), 20.0);
  ClosedLoop loop(reference, fieldOf({}));
  loop.input.law = slalom::test::lawTo(*reference, reference->end(), 0.4);
  loop.fly(6.0);
  EXPECT_NEAR(loop.command.v_W.x(), 0.4, 0.01);
  EXPECT_LE(loop.trackingError(), 0.02);
}

TEST(LocalPlannerTracking, PlansAreDynamicallyConsistent)
{
  const LocalPlannerConfig config;
  ClosedLoop loop(straightReference(Vector3d::Zero(), Vector3d(0.9, -0.5, 0.1), 20.0), fieldOf({}));
  loop.state.p_L += Vector3d(-0.4, 0.3, 0.2);
  loop.fly(4.0,
           [&](const auto& output)
           {
             ASSERT_EQ(output.horizon_L.cols(), config.horizon + 1);
             ASSERT_EQ(output.horizon_yaw.size(), config.horizon + 1);
             EXPECT_EQ(output.horizon_L.col(0), loop.input.state.p_L);
             const Vector3d first =
                 (output.horizon_L.col(1) - output.horizon_L.col(0)) / config.step_s;
             EXPECT_LE((first - output.command.v_W).norm(), 1e-2);
             for (int k = 0; k < config.horizon; ++k)
               EXPECT_LE(std::abs(output.horizon_yaw[k + 1] - output.horizon_yaw[k]),
                         1.0 * config.step_s + 1e-6);
           });
}

}  // namespace
