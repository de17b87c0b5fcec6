// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "slalom/core/Rng.h"
#include "slalom/spline/UniformBSpline.h"

namespace slalom::spline
{
namespace
{
using core::Rng;

Eigen::Matrix3Xd randomPoints(Rng& rng, Eigen::Index n)
{
  Eigen::Matrix3Xd points(3, n);
  for (Eigen::Index i = 0; i < n; ++i) points.col(i) = rng.uniform3(-3.0, 3.0);
  return points;
}

UniformBSpline randomCurve(Rng& rng)
{
  const Eigen::Index n = rng.integer(4, 20);
  return {randomPoints(rng, n), rng.uniform(0.05, 0.5), rng.uniform(-5.0, 5.0)};
}

/// A time at least `margin` away from every knot, so that differences stay within one span.
double timeInsideSpan(Rng& rng, const UniformBSpline& curve)
{
  const int span = rng.integer(0, static_cast<int>(curve.spans()) - 1);
  return curve.start() + curve.knotSpan() * (span + rng.uniform(0.05, 0.95));
}

TEST(UniformBSpline, DerivativesMatchFiniteDifferences)
{
  for (std::uint64_t seed = 0; seed < 500; ++seed)
  {
    SCOPED_TRACE(seed);
    Rng rng(seed);
    const UniformBSpline curve = randomCurve(rng);
    const double t = timeInsideSpan(rng, curve), h = 1e-4 * curve.knotSpan();
    const auto difference = [&](auto f) -> Eigen::Vector3d
    { return (f(t + h) - f(t - h)) / (2.0 * h); };
    const double d = curve.knotSpan();
    EXPECT_LT((difference([&](double s) { return curve.position(s); }) - curve.velocity(t)).norm(),
              1e-6 / d);
    EXPECT_LT(
        (difference([&](double s) { return curve.velocity(s); }) - curve.acceleration(t)).norm(),
        1e-6 / (d * d));
    EXPECT_LT((difference([&](double s) { return curve.acceleration(s); }) - curve.jerk(t)).norm(),
              1e-6 / (d * d * d));
  }
}

TEST(UniformBSpline, IsTwiceContinuouslyDifferentiableAcrossKnots)
{
  Rng rng(1);
  const UniformBSpline curve(randomPoints(rng, 12), 0.3, 1.0);
  for (int k = 1; k < curve.spans(); ++k)
  {
    const double knot = curve.start() + curve.knotSpan() * k, h = 1e-9;
    EXPECT_LT((curve.position(knot + h) - curve.position(knot - h)).norm(), 1e-6);
    EXPECT_LT((curve.velocity(knot + h) - curve.velocity(knot - h)).norm(), 1e-5);
    EXPECT_LT((curve.acceleration(knot + h) - curve.acceleration(knot - h)).norm(), 1e-4);
  }
}

// The four basis weights are read off by curves with one unit control point.
TEST(UniformBSpline, EveryPointIsAConvexCombinationOfItsFourControlPoints)
{
  Rng rng(2);
  for (int trial = 0; trial < 200; ++trial)
  {
    const Eigen::Index n = rng.integer(4, 12);
    const UniformBSpline any(Eigen::Matrix3Xd::Zero(3, n), 0.2, 0.0);
    const double t = rng.uniform(any.start(), any.end());
    double sum = 0.0;
    for (Eigen::Index i = 0; i < n; ++i)
    {
      Eigen::Matrix3Xd unit = Eigen::Matrix3Xd::Zero(3, n);
      unit(0, i) = 1.0;
      const double weight = any.withControlPoints(unit).position(t).x();
      EXPECT_GE(weight, 0.0);
      const Eigen::Index span = any.spanAt(t);
      if (i < span || i > span + 3)
      {
        EXPECT_EQ(weight, 0.0);
      }
      sum += weight;
    }
    EXPECT_NEAR(sum, 1.0, 1e-14);
  }
}

TEST(UniformBSpline, StaysInTheHullOfItsFourControlPoints)
{
  for (std::uint64_t seed = 0; seed < 300; ++seed)
  {
    SCOPED_TRACE(seed);
    Rng rng(seed);
    const UniformBSpline curve = randomCurve(rng);
    const double t = rng.uniform(curve.start(), curve.end());
    const auto four = curve.controlPoints().middleCols<4>(curve.spanAt(t));
    for (int k = 0; k < 50; ++k)
    {
      const Eigen::Vector3d direction = rng.direction();
      EXPECT_LE(direction.dot(curve.position(t)),
                (direction.transpose() * four).maxCoeff() + 1e-12);
    }
  }
}

TEST(UniformBSpline, ReproducesLinesAndCommutesWithAffineMaps)
{
  for (std::uint64_t seed = 0; seed < 100; ++seed)
  {
    SCOPED_TRACE(seed);
    Rng rng(seed);
    const UniformBSpline curve = randomCurve(rng);
    Eigen::Matrix3d map;
    for (int k = 0; k < 3; ++k) map.col(k) = rng.uniform3(-2.0, 2.0);
    const Eigen::Vector3d shift = rng.uniform3(-10.0, 10.0);
    const Eigen::Matrix3Xd mapped = (map * curve.controlPoints()).colwise() + shift;
    const double t = rng.uniform(curve.start(), curve.end());
    EXPECT_LT(
        (curve.withControlPoints(mapped).position(t) - (map * curve.position(t) + shift)).norm(),
        1e-11);

    // Equidistant control points on a line: constant velocity, exactly.
    const Eigen::Vector3d v = rng.uniform3(-2.0, 2.0);
    Eigen::Matrix3Xd line(3, curve.size());
    for (Eigen::Index i = 0; i < curve.size(); ++i)
      line.col(i) = shift + v * curve.knotSpan() * static_cast<double>(i - 1);
    const UniformBSpline straight = curve.withControlPoints(line);
    EXPECT_LT((straight.position(t) - (shift + v * (t - curve.start()))).norm(), 1e-11);
    EXPECT_LT((straight.velocity(t) - v).norm(), 1e-10);
  }
}

TEST(UniformBSpline, DerivativesStayWithinTheirControlPoints)
{
  for (std::uint64_t seed = 0; seed < 200; ++seed)
  {
    SCOPED_TRACE(seed);
    Rng rng(seed);
    const UniformBSpline curve = randomCurve(rng);
    const Eigen::Matrix3Xd v = curve.velocityControlPoints(), a = curve.accelerationControlPoints();
    ASSERT_EQ(v.cols(), curve.size() - 1);
    ASSERT_EQ(a.cols(), curve.size() - 2);
    const double t = rng.uniform(curve.start(), curve.end());
    const Eigen::Index i = curve.spanAt(t);
    for (int axis = 0; axis < 3; ++axis)
    {
      EXPECT_LE(curve.velocity(t)[axis], v.middleCols<3>(i).row(axis).maxCoeff() + 1e-9);
      EXPECT_GE(curve.velocity(t)[axis], v.middleCols<3>(i).row(axis).minCoeff() - 1e-9);
      EXPECT_LE(curve.acceleration(t)[axis], a.middleCols<2>(i).row(axis).maxCoeff() + 1e-8);
      EXPECT_GE(curve.acceleration(t)[axis], a.middleCols<2>(i).row(axis).minCoeff() - 1e-8);
    }
  }
}

TEST(UniformBSpline, ClampsTimeToItsDomain)
{
  Rng rng(3);
  const UniformBSpline curve(randomPoints(rng, 7), 0.2, 2.0);
  EXPECT_DOUBLE_EQ(curve.end(), 2.8);
  EXPECT_EQ(curve.spanAt(-1e300), 0);
  EXPECT_EQ(curve.spanAt(1e300), curve.spans() - 1);
  EXPECT_EQ(curve.spanAt(curve.end()), curve.spans() - 1);
  EXPECT_EQ(curve.position(-100.0), curve.position(curve.start()));
  EXPECT_EQ(curve.position(100.0), curve.position(curve.end()));
  EXPECT_EQ(curve.velocity(100.0), curve.velocity(curve.end()));
  EXPECT_TRUE(curve.position(std::numeric_limits<double>::quiet_NaN()).allFinite());
}

TEST(UniformBSpline, ProjectionIsAsNearAsBruteForce)
{
  for (std::uint64_t seed = 0; seed < 200; ++seed)
  {
    SCOPED_TRACE(seed);
    Rng rng(seed);
    const UniformBSpline curve = randomCurve(rng);
    const Eigen::Vector3d p = rng.uniform3(-4.0, 4.0);
    double from = rng.uniform(curve.start() - 0.2, curve.end());
    double to = rng.uniform(from, curve.end() + 0.2);
    const double t = curve.project(p, from, to);
    from = std::clamp(from, curve.start(), curve.end());
    to = std::clamp(to, from, curve.end());
    EXPECT_GE(t, from);
    EXPECT_LE(t, to);
    const Eigen::Matrix3Xd dense = curve.sample(from, to, 4000);
    const double brute = (dense.colwise() - p).colwise().norm().minCoeff();
    EXPECT_LE((curve.position(t) - p).norm(), brute + 1e-12);
    // An interior minimum is stationary.
    if (t > from + 1e-6 && t < to - 1e-6)
    {
      EXPECT_NEAR((curve.position(t) - p).dot(curve.velocity(t)), 0.0,
                  1e-5 * curve.velocity(t).squaredNorm() + 1e-9);
    }
  }
}

TEST(UniformBSpline, ProjectionOfACurvePointFindsIt)
{
  for (std::uint64_t seed = 0; seed < 200; ++seed)
  {
    SCOPED_TRACE(seed);
    Rng rng(seed);
    const UniformBSpline curve = randomCurve(rng);
    const Eigen::Vector3d p = curve.position(rng.uniform(curve.start(), curve.end()));
    const double t = curve.project(p, curve.start(), curve.end());
    EXPECT_LT((curve.position(t) - p).norm(), 1e-7);
  }
}

TEST(UniformBSpline, LengthMatchesADensePolyline)
{
  for (std::uint64_t seed = 0; seed < 100; ++seed)
  {
    SCOPED_TRACE(seed);
    Rng rng(seed);
    const UniformBSpline curve = randomCurve(rng);
    const double from = rng.uniform(curve.start(), curve.end());
    const double to = rng.uniform(from, curve.end());
    const Eigen::Matrix3Xd dense = curve.sample(from, to, 20001);
    const double polyline = (dense.rightCols(20000) - dense.leftCols(20000)).colwise().norm().sum();
    EXPECT_NEAR(curve.length(from, to), polyline, 2e-3 * polyline + 1e-9);
    const double mid = 0.5 * (from + to);
    EXPECT_NEAR(curve.length(from, mid) + curve.length(mid, to), curve.length(from, to),
                2e-3 * polyline + 1e-9);
    EXPECT_EQ(curve.length(to, from), from == to ? curve.length(from, to) : 0.0);
  }
}

TEST(UniformBSpline, RefusesWhatIsNoCurve)
{
  const Eigen::Matrix3Xd four = Eigen::Matrix3Xd::Zero(3, 4);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_NO_THROW(UniformBSpline(four, 0.1));
  EXPECT_THROW(UniformBSpline(Eigen::Matrix3Xd::Zero(3, 3), 0.1), std::invalid_argument);
  EXPECT_THROW(UniformBSpline(four, 0.0), std::invalid_argument);
  EXPECT_THROW(UniformBSpline(four, -1.0), std::invalid_argument);
  EXPECT_THROW(UniformBSpline(four, nan), std::invalid_argument);
  EXPECT_THROW(UniformBSpline(four, 0.1, nan), std::invalid_argument);
  EXPECT_THROW(UniformBSpline(Eigen::Matrix3Xd::Constant(3, 4, nan), 0.1), std::invalid_argument);
  const UniformBSpline curve(four, 0.1);
  EXPECT_THROW((void)curve.sample(0.0, 0.1, 1), std::invalid_argument);
  EXPECT_THROW((void)curve.withControlPoints(Eigen::Matrix3Xd::Zero(3, 5)), std::invalid_argument);
}

}  // namespace
}  // namespace slalom::spline
