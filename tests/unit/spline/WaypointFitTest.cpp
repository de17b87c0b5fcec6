// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

#include "slalom/core/Rng.h"
#include "slalom/spline/WaypointFit.h"

namespace slalom::spline
{
namespace
{
using core::Rng;

Eigen::Matrix3Xd randomMission(Rng& rng)
{
  const int count = rng.integer(2, 12);
  Eigen::Matrix3Xd waypoints(3, count);
  Eigen::Vector3d p = rng.uniform3(-5.0, 5.0);
  for (int i = 0; i < count; ++i)
  {
    waypoints.col(i) = p;
    const int kind = rng.integer(0, 9);
    if (kind == 0) continue;  // a duplicate
    if (kind == 1 && i > 0)
      p = waypoints.col(i - 1);  // a reversal
    else
      p += rng.direction() * std::exp(rng.uniform(std::log(0.2), std::log(20.0)));
  }
  waypoints.col(count - 1) += Eigen::Vector3d(0.5, 0.1, 0.2);
  return waypoints;
}

FitLimits randomLimits(Rng& rng)
{
  FitLimits limits;
  limits.max_speed = rng.uniform(0.4, 5.0);
  limits.max_acceleration = rng.uniform(0.4, 6.0);
  limits.knot_span = rng.uniform(0.05, 0.3);
  return limits;
}

double distanceToSegment(const Eigen::Vector3d& p, const Eigen::Vector3d& a,
                         const Eigen::Vector3d& b)
{
  const Eigen::Vector3d ab = b - a;
  const double s = std::clamp((p - a).dot(ab) / std::max(ab.squaredNorm(), 1e-300), 0.0, 1.0);
  return (p - a - s * ab).norm();
}

/// How far a control polygon of such limits can be from the passage it samples.
double samplingError(const FitLimits& limits)
{
  return std::numbers::sqrt3 * limits.max_acceleration * limits.knot_span * limits.knot_span / 6.0;
}

TEST(WaypointFit, KeepsLimitsInTheHullsAndOnTheDenseCurve)
{
  for (std::uint64_t seed = 0; seed < 300; ++seed)
  {
    SCOPED_TRACE(seed);
    Rng rng(seed);
    const Eigen::Matrix3Xd waypoints = randomMission(rng);
    const FitLimits limits = randomLimits(rng);
    const UniformBSpline curve = fitWaypoints(waypoints, limits);
    EXPECT_LE(curve.velocityControlPoints().cwiseAbs().maxCoeff(), limits.max_speed);
    EXPECT_LE(curve.accelerationControlPoints().cwiseAbs().maxCoeff(), limits.max_acceleration);
    EXPECT_EQ(curve.knotSpan(), limits.knot_span);
    for (double t = curve.start(); t <= curve.end(); t += 0.37 * curve.knotSpan())
    {
      ASSERT_LE(curve.velocity(t).cwiseAbs().maxCoeff(), limits.max_speed + 1e-9);
      ASSERT_LE(curve.acceleration(t).cwiseAbs().maxCoeff(), limits.max_acceleration + 1e-9);
    }
  }
}

TEST(WaypointFit, IsAtRestAtBothEndsExactlyOnTheWaypoints)
{
  for (std::uint64_t seed = 0; seed < 200; ++seed)
  {
    SCOPED_TRACE(seed);
    Rng rng(seed);
    const Eigen::Matrix3Xd waypoints = randomMission(rng);
    const UniformBSpline curve = fitWaypoints(waypoints, randomLimits(rng));
    EXPECT_LT((curve.position(curve.start()) - waypoints.leftCols<1>()).norm(), 1e-12);
    EXPECT_LT((curve.position(curve.end()) - waypoints.rightCols<1>()).norm(), 1e-12);
    for (const double t : {curve.start(), curve.end()})
    {
      EXPECT_LT(curve.velocity(t).norm(), 1e-9);
      EXPECT_LT(curve.acceleration(t).norm(), 1e-8);
    }
  }
}

TEST(WaypointFit, PassesEveryWaypointInOrder)
{
  for (std::uint64_t seed = 0; seed < 200; ++seed)
  {
    SCOPED_TRACE(seed);
    Rng rng(seed);
    const Eigen::Matrix3Xd waypoints = randomMission(rng);
    const FitLimits limits = randomLimits(rng);
    const UniformBSpline curve = fitWaypoints(waypoints, limits);
    const double tolerance = samplingError(limits) + 1.1e-3;
    double t = curve.start();
    for (Eigen::Index i = 0; i < waypoints.cols(); ++i)
    {
      // First time from t on at which the curve is at the waypoint; in order, or not at all.
      const double step = 0.1 * tolerance / limits.max_speed;
      while (t < curve.end() && (curve.position(t) - waypoints.col(i)).norm() > tolerance)
        t += step;
      ASSERT_LE((curve.position(t) - waypoints.col(i)).norm(), tolerance) << "waypoint " << i;
    }
  }
}

TEST(WaypointFit, DefaultLimitsPassWaypointsWithinTwoCentimetres)
{
  for (std::uint64_t seed = 0; seed < 100; ++seed)
  {
    SCOPED_TRACE(seed);
    Rng rng(seed);
    const Eigen::Matrix3Xd waypoints = randomMission(rng);
    const UniformBSpline curve = fitWaypoints(waypoints, {});
    for (Eigen::Index i = 0; i < waypoints.cols(); ++i)
    {
      const double t = curve.project(waypoints.col(i), curve.start(), curve.end());
      EXPECT_LT((curve.position(t) - waypoints.col(i)).norm(), 0.02);
    }
  }
}

// Near each leg, the path leaves the polyline by at most 0.3 x the shorter of the legs that meet at
// the leg's two corners.
TEST(WaypointFit, DoesNotSwingWide)
{
  double worst = 0.0;
  for (std::uint64_t seed = 0; seed < 300; ++seed)
  {
    SCOPED_TRACE(seed);
    Rng rng(seed);
    const int count = rng.integer(3, 10);
    Eigen::Matrix3Xd waypoints(3, count);
    waypoints.col(0).setZero();
    for (int i = 1; i < count; ++i)
      waypoints.col(i) = waypoints.col(i - 1) + rng.direction() * rng.uniform(0.5, 20.0);
    const FitLimits limits = randomLimits(rng);
    const UniformBSpline curve = fitWaypoints(waypoints, limits);
    const Eigen::Index legs = count - 1;
    const Eigen::RowVectorXd length =
        (waypoints.rightCols(legs) - waypoints.leftCols(legs)).colwise().norm();
    const auto shorter = [&](Eigen::Index corner)
    {
      if (corner == 0) return length[0];
      if (corner == legs) return length[legs - 1];
      return std::min(length[corner - 1], length[corner]);
    };
    for (double t = curve.start(); t <= curve.end(); t += 0.02)
    {
      double over = std::numeric_limits<double>::infinity();
      for (Eigen::Index k = 0; k < legs; ++k)
      {
        const double away =
            distanceToSegment(curve.position(t), waypoints.col(k), waypoints.col(k + 1)) -
            samplingError(limits);
        over = std::min(over, away / std::max(shorter(k), shorter(k + 1)));
      }
      worst = std::max(worst, over);
      ASSERT_LE(over, 0.3);
    }
  }
  RecordProperty("worst_ratio", std::to_string(worst));
}

TEST(WaypointFit, TwoWaypointsAreAStraightLineNearTheTrapezoidOptimum)
{
  for (std::uint64_t seed = 0; seed < 200; ++seed)
  {
    SCOPED_TRACE(seed);
    Rng rng(seed);
    const FitLimits limits;
    const Eigen::Vector3d a = rng.uniform3(-5.0, 5.0), direction = rng.direction();
    const double length = rng.uniform(2.0, 60.0);
    Eigen::Matrix3Xd waypoints(3, 2);
    waypoints << a, a + length * direction;
    const UniformBSpline curve = fitWaypoints(waypoints, limits);
    for (double t = curve.start(); t <= curve.end(); t += 0.05)
      ASSERT_LT(distanceToSegment(curve.position(t), waypoints.col(0), waypoints.col(1)), 1e-9);

    // The axis that moves most is the one that limits.
    const double share = direction.cwiseAbs().maxCoeff();
    const double v = limits.max_speed / share, acc = limits.max_acceleration / share;
    const double optimum =
        length > v * v / acc ? length / v + v / acc : 2.0 * std::sqrt(length / acc);
    EXPECT_GE(curve.duration(), optimum);
    EXPECT_LE(curve.duration(), 1.15 * optimum);
  }
}

TEST(WaypointFit, FollowsACircleOfWaypointsSmoothlyAndFast)
{
  constexpr double kRadius = 5.0;
  constexpr int kCount = 33;
  Eigen::Matrix3Xd waypoints(3, kCount);
  for (int i = 0; i < kCount; ++i)
  {
    const double angle = 2.0 * std::numbers::pi * i / (kCount - 1);
    waypoints.col(i) << kRadius * std::cos(angle), kRadius * std::sin(angle), 2.0;
  }
  const UniformBSpline curve = fitWaypoints(waypoints, {});
  for (double t = curve.start(); t <= curve.end(); t += 0.05)
    EXPECT_NEAR(curve.position(t).head<2>().norm(), kRadius, 0.03);
  // 26 s at the speed that 1.2 m/s per axis allows everywhere.
  EXPECT_LT(curve.duration(), 2.0 * std::numbers::pi * kRadius / 1.2 + 2.0);
}

TEST(WaypointFit, DuplicatesChangeNothing)
{
  Eigen::Matrix3Xd clean(3, 3), repeated(3, 7);
  clean << 0, 5, 5, 0, 0, 5, 1, 1, 1;
  repeated << clean.col(0), clean.col(0), clean.col(1), clean.col(1), clean.col(1), clean.col(2),
      clean.col(2);
  EXPECT_EQ(fitWaypoints(clean, {}).controlPoints(), fitWaypoints(repeated, {}).controlPoints());
}

TEST(WaypointFit, StopsAtAReversalAndComesBack)
{
  Eigen::Matrix3Xd there_and_back(3, 3);
  there_and_back << 0, 10, 0, 0, 0, 0, 1, 1, 1;
  const UniformBSpline curve = fitWaypoints(there_and_back, {});
  double farthest = 0.0;
  for (double t = curve.start(); t <= curve.end(); t += 0.02)
  {
    const Eigen::Vector3d p = curve.position(t);
    EXPECT_LT(std::hypot(p.y(), p.z() - 1.0), 1e-9);
    farthest = std::max(farthest, p.x());
  }
  EXPECT_NEAR(farthest, 10.0, 0.01);
}

TEST(WaypointFit, LongReferenceWithReversalsAndSelfCrossings)
{
  Rng rng(7);
  Eigen::Matrix3Xd waypoints(3, 40);
  double length = 0.0;
  waypoints.col(0).setZero();
  for (int i = 1; i < 40; ++i)
  {
    const Eigen::Vector3d step(rng.uniform(-25, 25), rng.uniform(-25, 25), rng.uniform(-1, 1));
    waypoints.col(i) = waypoints.col(i - 1) + step;
    if (i % 9 == 0) waypoints.col(i) = waypoints.col(i - 2);
    length += (waypoints.col(i) - waypoints.col(i - 1)).norm();
  }
  ASSERT_GT(length, 500.0);
  const FitLimits limits;
  const UniformBSpline curve = fitWaypoints(waypoints, limits);
  EXPECT_LE(curve.velocityControlPoints().cwiseAbs().maxCoeff(), limits.max_speed);
  EXPECT_LE(curve.accelerationControlPoints().cwiseAbs().maxCoeff(), limits.max_acceleration);
  EXPECT_NEAR(curve.length(curve.start(), curve.end()), length, 0.05 * length);
  // At most: every leg from rest to rest.
  EXPECT_LT(curve.duration(), length / limits.max_speed + 39 * 1.2 + 5.0);
}

TEST(WaypointFit, RefusesWhatIsNoMission)
{
  Eigen::Matrix3Xd two(3, 2);
  two << 0, 1, 0, 0, 0, 0;
  EXPECT_THROW((void)fitWaypoints(two.leftCols(1), {}), std::invalid_argument);
  EXPECT_THROW((void)fitWaypoints(Eigen::Matrix3Xd(3, 0), {}), std::invalid_argument);
  EXPECT_THROW((void)fitWaypoints(Eigen::Matrix3Xd::Ones(3, 5), {}), std::invalid_argument);
  Eigen::Matrix3Xd broken = two;
  broken(1, 1) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW((void)fitWaypoints(broken, {}), std::invalid_argument);
  EXPECT_THROW((void)fitWaypoints(two, {0.0, 1.0, 0.2}), std::invalid_argument);
  EXPECT_THROW((void)fitWaypoints(two, {1.0, -1.0, 0.2}), std::invalid_argument);
  EXPECT_THROW((void)fitWaypoints(two, {1.0, 1.0, 0.0}), std::invalid_argument);
}

}  // namespace
}  // namespace slalom::spline
