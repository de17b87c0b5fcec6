// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <thread>

#include "slalom/core/Deadline.h"
#include "slalom/core/HalfSpaces.h"
#include "slalom/core/Math.h"
#include "slalom/core/Published.h"
#include "slalom/core/Rng.h"
#include "slalom/core/SolveReport.h"
#include "slalom/core/VelocityResponse.h"

namespace slalom::core
{
namespace
{
TEST(Math, WrapAngleIsTheSameAngleInRange)
{
  Rng rng(1);
  for (int k = 0; k < 10000; ++k)
  {
    const double angle = rng.uniform(-100.0, 100.0), wrapped = wrapAngle(angle);
    EXPECT_GE(wrapped, -std::numbers::pi);
    EXPECT_LT(wrapped, std::numbers::pi);
    EXPECT_NEAR(std::cos(angle), std::cos(wrapped), 1e-12);
    EXPECT_NEAR(std::sin(angle), std::sin(wrapped), 1e-12);
  }
}

TEST(Math, ExponentialIsARotationByItsNorm)
{
  Rng rng(2);
  for (const double size : {1e-12, 1e-8, 1e-4, 0.1, 1.0, 3.0})
    for (int k = 0; k < 200; ++k)
    {
      const Eigen::Vector3d phi = size * rng.direction(), v = rng.uniform3(-1, 1);
      EXPECT_NEAR(expSO3(phi).norm(), 1.0, 1e-12);
      const Eigen::AngleAxisd expected(size, phi.normalized());
      EXPECT_LT((expSO3(phi) * v - expected * v).norm(), 1e-12);
      EXPECT_LT((skew(phi) * v - phi.cross(v)).norm(), 1e-12);
    }
}

TEST(Math, YawSurvivesTheRoundTrip)
{
  for (double yaw = -3.1; yaw < 3.1; yaw += 0.1) EXPECT_NEAR(yawOf(fromYaw(yaw)), yaw, 1e-12);
}

TEST(Rng, GivesTheSameNumbersForTheSameSeed)
{
  Rng a(7), b(7), c(8);
  EXPECT_EQ(a.bits(), b.bits());
  EXPECT_NE(a.bits(), c.bits());
}

TEST(Rng, HasTheMomentsItPromises)
{
  Rng rng(3);
  constexpr int kSamples = 200000;
  double sum = 0, square = 0, mean = 0, lowest = 1, highest = 0;
  Eigen::Vector3d direction = Eigen::Vector3d::Zero();
  for (int k = 0; k < kSamples; ++k)
  {
    const double n = rng.normal(), u = rng.uniform();
    sum += n / kSamples, square += n * n / kSamples, mean += u / kSamples;
    lowest = std::min(lowest, u), highest = std::max(highest, u);
    direction += rng.direction() / kSamples;
    const int i = rng.integer(-2, 2);
    EXPECT_TRUE(i >= -2 && i <= 2);
  }
  EXPECT_NEAR(sum, 0.0, 0.01);
  EXPECT_NEAR(square, 1.0, 0.02);
  EXPECT_NEAR(mean, 0.5, 0.005);
  EXPECT_TRUE(lowest >= 0.0 && highest < 1.0);
  EXPECT_LT(direction.norm(), 0.01);
}

TEST(HalfSpaces, ViolationIsTheWorstPlane)
{
  HalfSpaces box;
  box.A.resize(2, 3);
  box.A << 1, 0, 0, 0, 1, 0;
  box.b = Eigen::Vector2d(1.0, 2.0);
  EXPECT_DOUBLE_EQ(box.violation({1.5, 1.0, 0.0}), 0.5);
  EXPECT_TRUE(box.contains({0.5, 1.0, 9.0}));
  EXPECT_FALSE(box.contains({0.5, 2.1, 0.0}));
  EXPECT_TRUE(HalfSpaces{}.contains({1e9, 0, 0}));
}

TEST(SolveReport, SaysTheTruthBeforeTheFact)
{
  const SolveReport report;
  EXPECT_FALSE(report.converged());
  EXPECT_TRUE(std::isnan(report.cost));
  EXPECT_EQ(toString(report.termination), "NotRun");
}

TEST(Deadline, NeverPassesUnlessItIsSet)
{
  EXPECT_FALSE(Deadline::none().passed());
  EXPECT_TRUE(Deadline::in(std::chrono::nanoseconds(0)).passed());
  EXPECT_FALSE(Deadline::in(std::chrono::hours(1)).passed());
}

TEST(VelocityResponse, IsTheLimitOfSmallSteps)
{
  for (const double lag : {0.0, 0.05, 0.2, 2.0})
  {
    Vehicle vehicle;
    vehicle.velocity_lag_s = lag;
    vehicle.yaw_rate_lag_s = 0.5 * lag;
    const VelocityCommand command{{1.0, -2.0, 0.5}, 0.7};
    const Motion start{{1, 2, 3}, {-1, 0.5, 0}, 0.4, -0.2};
    const Motion once = held(start, command, 0.3, vehicle);
    Motion fine = start;
    constexpr int kSteps = 100000;
    for (int k = 0; k < kSteps; ++k)
    {
      const double dt = 0.3 / kSteps;
      const Eigen::Vector3d v = fine.v;
      const double rate = fine.yaw_rate;
      fine.v = lag > 0.0 ? Eigen::Vector3d(v + (command.v_W - v) * (dt / lag)) : command.v_W;
      fine.yaw_rate =
          lag > 0.0 ? rate + (command.yaw_rate - rate) * (2.0 * dt / lag) : command.yaw_rate;
      fine.p +=
          0.5 * dt * (lag > 0.0 ? Eigen::Vector3d(v + fine.v) : Eigen::Vector3d(2.0 * fine.v));
      fine.yaw += 0.5 * dt * (lag > 0.0 ? rate + fine.yaw_rate : 2.0 * fine.yaw_rate);
    }
    EXPECT_LT((once.p - fine.p).norm(), 1e-4) << lag;
    EXPECT_LT((once.v - fine.v).norm(), 1e-4) << lag;
    EXPECT_NEAR(once.yaw, fine.yaw, 1e-4) << lag;
    EXPECT_NEAR(once.yaw_rate, fine.yaw_rate, 1e-4) << lag;
  }
}

TEST(Published, ReadersSeeWholeSnapshotsInOrder)
{
  Published<std::pair<int, int>> shared;
  EXPECT_EQ(shared.latest(), nullptr);
  std::thread writer(
      [&shared]
      {
        for (int k = 1; k <= 2000; ++k)
          shared.publish(std::make_shared<const std::pair<int, int>>(k, -k));
      });
  int last = 0;
  while (last < 2000)
  {
    const auto snapshot = shared.latest();
    if (!snapshot) continue;
    ASSERT_EQ(snapshot->first, -snapshot->second);
    ASSERT_GE(snapshot->first, last);
    last = snapshot->first;
  }
  writer.join();
}

}  // namespace
}  // namespace slalom::core
