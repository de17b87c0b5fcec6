// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <numbers>

#include "ClosedLoop.h"
#include "HorizonReference.h"
#include "Plan.h"
#include "slalom/core/Rng.h"

namespace
{
using Eigen::Vector3d;
using slalom::core::Rng;
using slalom::core::Vehicle;
using slalom::local_planner::LocalPlannerConfig;
using slalom::local_planner::LocalPlannerInput;
using namespace slalom::local_planner::detail;
using slalom::test::straightReference;

LocalPlannerInput along(const Vector3d& velocity, double yaw)
{
  LocalPlannerInput input;
  input.reference = straightReference(Vector3d(1.0, 2.0, 3.0), velocity, 20.0);
  input.progress = 2.0;
  input.law = slalom::test::lawTo(*input.reference, input.reference->end());
  input.state.q_WB = slalom::core::fromYaw(yaw);
  return input;
}

TEST(HorizonReference, FollowsTheSplineAndRestsAtItsStop)
{
  const LocalPlannerConfig config;
  LocalPlannerInput input = along(Vector3d(1.0, 0.0, 0.2), 0.0);
  const auto law = slalom::test::lawTo(*input.reference, 2.5, 0.5);  // half pace, then a stop
  input.law = law;
  const HorizonReference horizon =
      sampleHorizon(input, config, slalom::test::atOnce(), std::nullopt);
  for (int k = 0; k <= config.horizon; ++k)
  {
    const double parameter = law->advance(2.0, 0.1 * k);
    EXPECT_LE((horizon.positions.col(k) - input.reference->position(parameter)).norm(), 1e-9);
    if (k == config.horizon) break;
    const double middle = law->advance(2.0, 0.1 * k + 0.05);
    const double pace = middle < 2.5 ? law->pace(middle) : 0.0;
    const Vector3d v = pace * Vector3d(1.0, 0.0, 0.2);
    EXPECT_LE((horizon.commands.col(k) - v).norm(), 1e-9) << k;
    if (k < 7)
    {
      EXPECT_NEAR(pace, 0.5, 1e-6) << "the speed limit";
    }
  }
  EXPECT_LE((horizon.positions.col(config.horizon) - input.reference->position(2.5)).norm(), 1e-6);
}

TEST(HorizonReference, CommandsLeadFromPointToPointOnCurves)
{
  // Feed-forward that does not match the points would make the vehicle lag.
  Eigen::Matrix3Xd points(3, 40);
  points.col(0).setZero();
  for (int i = 1; i < 40; ++i)
    points.col(i) = points.col(i - 1) + 0.2 * Vector3d(0.8, 0.3 * std::sin(0.4 * i), 0.0);
  LocalPlannerInput input;
  input.reference = std::make_shared<slalom::spline::UniformBSpline>(points, 0.2);
  input.progress = 1.0;
  input.law = slalom::test::lawTo(*input.reference, input.reference->end());
  for (const double lag : {0.0, 0.1, 0.3})
    for (const double wind : {0.0, 0.7})
    {
      SCOPED_TRACE(testing::Message() << "lag " << lag << ", wind " << wind);
      Vehicle vehicle;
      vehicle.velocity_lag_s = lag;
      input.disturbance_W = Vector3d(0.0, wind, -0.3 * wind);
      const HorizonReference horizon = sampleHorizon(input, {}, vehicle, std::nullopt);
      const Model model{vehicle, 0.1, input.disturbance_W};
      slalom::core::Motion motion{horizon.positions.col(0), horizon.velocities.col(0), 0.0, 0.0};
      for (int k = 0; k < 25; ++k)
      {
        Eigen::Vector4d command;
        command << horizon.commands.col(k), 0.0;
        motion = model.after(motion, command);
        EXPECT_LE((motion.p - horizon.positions.col(k + 1)).norm(), 1.5e-3) << k;
      }
    }
}

TEST(HorizonReference, HeadingTurnsTheShortWayAndIsContinuous)
{
  for (std::uint64_t seed = 1; seed <= 500; ++seed)
  {
    SCOPED_TRACE(seed);
    Rng rng(seed);
    const double course = rng.uniform(-std::numbers::pi, std::numbers::pi);
    const double yaw = rng.uniform(-std::numbers::pi, std::numbers::pi);
    const LocalPlannerInput input = along(Vector3d(std::cos(course), std::sin(course), 0.3), yaw);
    const HorizonReference horizon = sampleHorizon(input, {}, Vehicle{}, rng.uniform(-9.0, 9.0));
    EXPECT_LE(std::abs(horizon.yaw[0] - yaw), std::numbers::pi + 1e-9);
    EXPECT_NEAR(slalom::core::wrapAngle(horizon.yaw[0] - course), 0.0, 1e-9);
    for (int k = 0; k < 15; ++k) EXPECT_NEAR(horizon.yaw[k + 1], horizon.yaw[k], 1e-9);
  }
}

TEST(HorizonReference, HeadingHoldsWhenSlow)
{
  const LocalPlannerInput slow = along(Vector3d(0.0, 0.15, 0.5), 1.0);  // climbs
  EXPECT_NEAR(sampleHorizon(slow, {}, Vehicle{}, std::nullopt).yaw[7], 1.0, 1e-9);
  EXPECT_NEAR(sampleHorizon(slow, {}, Vehicle{}, 0.4).yaw[7], 0.4, 1e-9);
  const LocalPlannerInput fast = along(Vector3d(0.0, 0.25, 0.5), 1.0);
  EXPECT_NEAR(sampleHorizon(fast, {}, Vehicle{}, 0.4).yaw[7], 0.5 * std::numbers::pi, 1e-9);
}

}  // namespace
