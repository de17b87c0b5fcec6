// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <vector>

#include "slalom/core/Rng.h"
#include "slalom/spline/TimeLaw.h"
#include "slalom/spline/WaypointFit.h"

namespace slalom::spline
{
namespace
{
using core::Rng;

constexpr MotionLimits kVehicle{1.2, 1.0};

/// A stretch of a curve, and how it is to be flown.
struct Case
{
  UniformBSpline curve;
  double from, to, start_pace;
  MotionLimits limits;

  [[nodiscard]] TimeLaw law() const { return {curve, from, to, start_pace, limits}; }
};

double logUniform(Rng& rng, double lo, double hi)
{
  return std::exp(rng.uniform(std::log(lo), std::log(hi)));
}

/// Control points from smooth to wild, some repeated (rest), some straight back (reversal).
UniformBSpline randomCurve(Rng& rng)
{
  const Eigen::Index n = rng.integer(4, 24);
  const double knot_span = logUniform(rng, 0.05, 0.6), step = logUniform(rng, 0.01, 1.0);
  const double roughness = rng.uniform() < 0.5 ? 0.2 : 2.0;
  Eigen::Matrix3Xd points(3, n);
  Eigen::Vector3d p = rng.uniform3(-5.0, 5.0), heading = rng.direction();
  const bool flat = rng.integer(0, 3) == 0;  // axes that never move
  for (Eigen::Index i = 0; i < n; ++i)
  {
    points.col(i) = p;
    if (flat) points.bottomRows<2>().col(i).setConstant(1.0);
    const int kind = rng.integer(0, 9);
    if (kind == 0) continue;
    if (kind == 1) heading = -heading;
    heading = (heading + roughness * rng.uniform() * rng.direction()).normalized();
    p += step * heading;
  }
  return {std::move(points), knot_span, rng.uniform(-50.0, 50.0)};
}

Case randomCase(std::uint64_t seed)
{
  Rng rng(seed);
  UniformBSpline curve = randomCurve(rng);
  double from = rng.uniform(curve.start(), curve.end()), to = rng.uniform(from, curve.end());
  if (rng.integer(0, 2) == 0) from = curve.start();
  if (rng.integer(0, 2) == 0) to = curve.end();
  const double start_pace = rng.integer(0, 1) == 0 ? 0.0 : rng.uniform();
  return {curve, from, to, start_pace, {logUniform(rng, 0.1, 5.0), logUniform(rng, 0.1, 10.0)}};
}

/// A straight line along x, `speed` on the curve's own timing.
UniformBSpline straight(double speed, Eigen::Index n = 100, double knot_span = 0.2)
{
  Eigen::Matrix3Xd points = Eigen::Matrix3Xd::Zero(3, n);
  for (Eigen::Index i = 0; i < n; ++i)
    points(0, i) = speed * knot_span * static_cast<double>(i - 1);
  return {std::move(points), knot_span};
}

/// A slalom at constant forward speed; sideways, its own timing needs `sideways` [m/s^2].
UniformBSpline weave(double forward, double sideways, double start = 0.0)
{
  constexpr double kSpan = 0.2, kOmega = 1.3;
  Eigen::Matrix3Xd points(3, 64);
  for (int i = 0; i < 64; ++i)
    points.col(i) << forward * kSpan * i,
        sideways / (kOmega * kOmega) * std::sin(kOmega * kSpan * i), 0.1 * std::cos(0.5 * i);
  return {std::move(points), kSpan, start};
}

Eigen::Vector3d velocity(const Case& c, const TimeLaw& law, double t)
{
  return c.curve.velocity(t) * law.pace(t);
}

/// Largest speed or acceleration relative to its limit, right of t and left of t.
double worstRatio(const Case& c, const TimeLaw& law, double t)
{
  constexpr double kBeside = 1e-9;
  double worst = velocity(c, law, t).cwiseAbs().maxCoeff() / c.limits.speed_mps;
  for (const double side : {t, t - kBeside})
  {
    if (side < c.from || side >= c.to) continue;
    const Eigen::Vector3d acceleration = c.curve.acceleration(side) * std::pow(law.pace(side), 2) +
                                         c.curve.velocity(side) * law.paceChange(side);
    worst = std::max(worst, acceleration.cwiseAbs().maxCoeff() / c.limits.acceleration_mps2);
  }
  return worst;
}

/// Dense times: ten per grid interval, every knot and both ends.
std::vector<double> denseTimes(const Case& c)
{
  std::vector<double> times;
  const double step = c.curve.knotSpan() / 40.0;
  for (double t = c.from; t < c.to; t += step) times.push_back(t);
  for (Eigen::Index k = 0; k <= 4 * c.curve.spans(); ++k)
    if (const double t = c.curve.start() + 0.25 * c.curve.knotSpan() * static_cast<double>(k);
        t > c.from && t < c.to)
      times.push_back(t);
  times.push_back(c.to);
  std::sort(times.begin(), times.end());
  return times;
}

TEST(TimeLaw, KeepsLimitsEverywhereOnThousandsOfCurves)
{
  int exceeding = 0, at_limit = 0;
  double worst_of_all = 0.0;
  for (std::uint64_t seed = 0; seed < 3000; ++seed)
  {
    SCOPED_TRACE(seed);
    const Case c = randomCase(seed);
    const TimeLaw law = c.law();
    ASSERT_GE(law.excess(), 0.0);
    double worst = 0.0;
    for (const double t : denseTimes(c)) worst = std::max(worst, worstRatio(c, law, t));
    ASSERT_LE(worst, (1.0 + law.excess()) * (1.0 + 1e-5));
    worst_of_all = std::max(worst_of_all, worst / (1.0 + law.excess()) - 1.0);
    if (law.excess() == 0.0) at_limit += worst > 0.9;
    exceeding += law.excess() > 0.0;
  }
  // The cases do test something: limits bind, and a part of the random starts is too fast.
  EXPECT_GT(at_limit, 1000);
  EXPECT_GT(exceeding, 100);
  EXPECT_LT(exceeding, 1500);
  RecordProperty("worst_excess", std::to_string(1e6 * worst_of_all) + "e-6");
}

TEST(TimeLaw, PaceIsBetweenZeroAndOneAndNeverStuck)
{
  for (std::uint64_t seed = 0; seed < 2000; ++seed)
  {
    SCOPED_TRACE(seed);
    const Case c = randomCase(seed);
    const TimeLaw law = c.law();
    ASSERT_EQ(law.from(), c.from);
    ASSERT_EQ(law.to(), c.to);
    ASSERT_TRUE(std::isfinite(law.duration()));
    ASSERT_GE(law.duration(), (c.to - c.from) * (1.0 - 1e-12));
    for (const double t : denseTimes(c))
    {
      ASSERT_GE(law.pace(t), 0.0);
      ASSERT_LE(law.pace(t), 1.0);
      ASSERT_TRUE(law.pace(t) > 0.0 || t == c.from || t == c.to) << t;
    }
    EXPECT_LE(velocity(c, law, c.to).cwiseAbs().maxCoeff(), 1.001e-4 * c.limits.speed_mps);
    // Where the curve moves, the law takes up the motion as it is.
    const bool moves = c.curve.velocity(c.from).cwiseAbs().maxCoeff() > 1e-4 * c.limits.speed_mps;
    EXPECT_TRUE(!moves || std::abs(law.pace(c.from) - c.start_pace) < 1e-4);
  }
}

TEST(TimeLaw, AdvanceIsTheIntegralOfPace)
{
  for (std::uint64_t seed = 0; seed < 200; ++seed)
  {
    SCOPED_TRACE(seed);
    const Case c = randomCase(seed);
    const TimeLaw law = c.law();
    // Time is the integral of 1 / pace; it may be infinite at the ends, so stay inside.
    const double margin = 0.1 * (c.to - c.from);
    double time = 0.0, t = c.from + margin;
    constexpr int kSteps = 20000;
    const double step = (c.to - c.from - 2.0 * margin) / kSteps;
    for (int i = 0; i < kSteps; ++i) time += step / law.pace(t + (i + 0.5) * step);
    EXPECT_NEAR(law.advance(t, time), c.to - margin, 1e-4 * (c.to - c.from));
  }
}

TEST(TimeLaw, AdvanceComposesIsMonotoneAndEndsAtTheEnd)
{
  for (std::uint64_t seed = 0; seed < 1000; ++seed)
  {
    SCOPED_TRACE(seed);
    const Case c = randomCase(seed);
    const TimeLaw law = c.law();
    Rng rng(seed + 1);
    const double scale = std::max(1.0, std::abs(c.to));
    for (int trial = 0; trial < 10; ++trial)
    {
      const double t = rng.uniform(c.from, c.to);
      const double a = law.duration() * std::pow(rng.uniform(), 3),
                   b = law.duration() * std::pow(rng.uniform(), 3);
      ASSERT_GE(law.advance(t, a), t);
      ASSERT_LE(law.advance(t, a), c.to);
      ASSERT_LE(law.advance(t, std::min(a, b)), law.advance(t, std::max(a, b)));
      // Near a stop, rounding of t hides up to sqrt(rounding) of time.
      ASSERT_NEAR(law.advance(t, a + b), law.advance(law.advance(t, a), b), 1e-9 * scale);
    }
    EXPECT_EQ(law.advance(c.from, 0.0), c.from);
    EXPECT_EQ(law.advance(c.from, -1.0), c.from);
    EXPECT_EQ(law.advance(c.from, law.duration() * (1.0 + 1e-12)), c.to);
    EXPECT_EQ(law.advance(c.to, 1.0), c.to);
    EXPECT_EQ(law.advance(c.to + 1.0, 1.0), c.to);
    // Stepping arrives, too, from rest as well.
    double t = c.from;
    const double tick = law.duration() / 100.0;
    for (int i = 0; i < 101; ++i) t = law.advance(t, tick);
    EXPECT_NEAR(t, c.to, 1e-9 * scale);
  }
}

TEST(TimeLaw, BrakesOverTheBrakingDistance)
{
  const double v = 0.9, a = 0.5;
  const UniformBSpline curve = straight(v);
  for (std::uint64_t seed = 0; seed < 50; ++seed)
  {
    SCOPED_TRACE(seed);
    Rng rng(seed);
    const double from = rng.uniform(0.0, 1.0), to = rng.uniform(6.0, curve.end());
    const TimeLaw law(curve, from, to, 1.0, {1.2, a});
    EXPECT_EQ(law.excess(), 0.0);
    const double brake_at = to - v * v / (2.0 * a) / v;
    // One grid interval holds the switch; on both sides the law is exact.
    const double cell = 0.25 * curve.knotSpan();
    for (double t = from; t < brake_at - cell; t += 0.01) ASSERT_NEAR(law.pace(t), 1.0, 1e-12);
    for (double t = brake_at + cell; t < to; t += 0.01)
      ASSERT_NEAR(law.pace(t), std::sqrt(2.0 * a * v * (to - t)) / v, 1e-9);
    EXPECT_NEAR(law.duration(), brake_at - from + v / a, 0.01);
  }
}

TEST(TimeLaw, ExcessIsWhatTheBrakingDistanceLacks)
{
  const double v = 1.1, a = 1.0;
  const UniformBSpline curve = straight(v);
  for (std::uint64_t seed = 0; seed < 300; ++seed)
  {
    SCOPED_TRACE(seed);
    Rng rng(seed);
    const double pace = rng.uniform(0.1, 1.0), from = rng.uniform(0.0, 5.0);
    const double needed = v * v * pace * pace / (2.0 * a), room = needed * rng.uniform(0.2, 1.8);
    const Case c{curve, from, from + room / v, pace, {1.2, a}};
    const TimeLaw law = c.law();
    EXPECT_NEAR(law.excess(), std::max(0.0, needed / room - 1.0), 1e-6 * (1.0 + law.excess()));
    EXPECT_EQ(law.excess() > 0.0, needed > room);
    EXPECT_TRUE(needed <= room || std::abs(law.duration() - 2.0 * room / (v * pace)) < 1e-6);
    EXPECT_EQ(law.pace(c.to), 0.0);
  }
}

// Starts are too fast from some pace on, and the more so the faster they are.
TEST(TimeLaw, ExcessGrowsWithTheStart)
{
  for (std::uint64_t seed = 0; seed < 300; ++seed)
  {
    SCOPED_TRACE(seed);
    Case c = randomCase(seed);
    double before = 0.0;
    for (int i = 0; i <= 20; ++i)
    {
      c.start_pace = 0.05 * i;
      const double excess = c.law().excess();
      ASSERT_TRUE(i > 0 || excess == 0.0);
      ASSERT_TRUE(before == 0.0 || excess > 0.0);
      before = excess;
    }
  }
}

// With the acceleration that excess() names, the same start keeps its limits; with less, it does
// not.
TEST(TimeLaw, ExcessIsNeededAndEnough)
{
  int too_fast = 0;
  for (std::uint64_t seed = 0; seed < 600; ++seed)
  {
    SCOPED_TRACE(seed);
    Case c = randomCase(seed);
    c.start_pace = 1.0;
    c.limits.speed_mps = 1e3;  // acceleration alone is in question
    const double acceleration = c.limits.acceleration_mps2, excess = c.law().excess();
    if (!(excess > 0.01)) continue;
    ++too_fast;
    c.limits.acceleration_mps2 = acceleration * (1.0 + excess) * 1.001;
    EXPECT_EQ(c.law().excess(), 0.0);
    c.limits.acceleration_mps2 = acceleration * (1.0 + excess) * 0.995;
    EXPECT_GT(c.law().excess(), 0.0);
  }
  EXPECT_GT(too_fast, 100);
}

TEST(TimeLaw, TooFastOnlyInSpeedBrakesWithinTheAcceleration)
{
  const Case c{straight(3.0), 1.0, 15.0, 1.0, {1.2, 0.8}};
  const TimeLaw law = c.law();
  EXPECT_NEAR(law.excess(), 3.0 / 1.2 - 1.0, 1e-9);
  double slowed_at = c.from;
  for (double t = c.from; t < c.to; t += 0.01)
  {
    const double speed = velocity(c, law, t).x();
    ASSERT_LE(std::abs(3.0 * law.paceChange(t)), 0.8 + 1e-9);
    if (speed > 1.2 + 1e-9) slowed_at = t;
  }
  EXPECT_NEAR(3.0 * (slowed_at - c.from), (9.0 - 1.44) / 1.6, 3.0 * 0.06);
  EXPECT_NEAR(velocity(c, law, 8.0).x(), 1.2, 1e-9);
}

TEST(TimeLaw, CurveWithinItsLimitsKeepsItsOwnTimingUntilTheStop)
{
  const UniformBSpline curve = weave(0.7, 0.6);
  const Case c{curve, curve.start(), curve.end(), 1.0, kVehicle};
  const TimeLaw law = c.law();
  EXPECT_EQ(law.excess(), 0.0);
  const double speed = 1.2;
  for (double t = c.from; t < c.to - 3.0 * speed; t += 0.01) ASSERT_EQ(law.pace(t), 1.0);
  EXPECT_EQ(law.pace(c.to), 0.0);
}

TEST(TimeLaw, ReferenceFromRestToRestIsFlownAsItIs)
{
  for (std::uint64_t seed = 0; seed < 100; ++seed)
  {
    SCOPED_TRACE(seed);
    Rng rng(seed);
    Eigen::Matrix3Xd waypoints(3, 5);
    Eigen::Vector3d p = Eigen::Vector3d::Zero();
    for (int i = 0; i < 5; ++i) waypoints.col(i) = p += rng.uniform3(-8.0, 8.0);
    const UniformBSpline r = fitWaypoints(waypoints, {});
    const MotionLimits limits{1.2, 1.0 + 1e-6};
    for (const double start_pace : {0.0, 0.3, 1.0})
    {
      const TimeLaw law(r, r.start(), r.end(), start_pace, limits);
      EXPECT_EQ(law.excess(), 0.0);
      // Bernstein coefficients never underestimate an acceleration, so a little pace may go.
      EXPECT_NEAR(law.duration(), r.duration(), 1e-3 * r.duration());
      EXPECT_EQ(law.pace(r.start()), 1.0);
    }
  }
}

TEST(TimeLaw, FreshStartInTheMiddleGetsGoingAtFullAcceleration)
{
  for (std::uint64_t seed = 0; seed < 200; ++seed)
  {
    SCOPED_TRACE(seed);
    Rng rng(seed);
    const double v = rng.uniform(0.2, 1.1), a = rng.uniform(0.3, 2.0);
    const UniformBSpline curve = straight(v);
    const double from = rng.uniform(0.0, 5.0);
    const TimeLaw law(curve, from, 18.0, 0.0, {1.2, a});
    EXPECT_EQ(law.pace(from), 0.0);
    // x = a tau^2 / 2 while accelerating; t counts v metres per second.
    for (double tau = 0.001; tau < 0.8 * v / a; tau *= 2.0)
      EXPECT_NEAR(v * (law.advance(from, tau) - from), 0.5 * a * tau * tau,
                  1e-9 + 0.05 * 0.25 * v * tau);
    EXPECT_NEAR(law.duration(), 18.0 - from + v / a, 0.02);
  }
}

// From rest with acceleration b on its own timing, a curve can be followed at pace sqrt(a / b).
TEST(TimeLaw, CurveThatStartsFromRestByAcceleratingTooHard)
{
  const double b = 4.0, d = 0.2;
  Eigen::Matrix3Xd points = Eigen::Matrix3Xd::Zero(3, 40);
  for (int i = 0; i < 40; ++i) points(0, i) = 0.5 * b * d * d * (i - 1) * (i - 1);
  const UniformBSpline curve(points, d);
  ASSERT_LT(curve.velocity(0.0).norm(), 1e-12);
  ASSERT_NEAR(curve.acceleration(0.0).x(), b, 1e-9);
  for (const double start_pace : {0.0, 0.2, 1.0})
  {
    const TimeLaw law(curve, 0.0, 3.0, start_pace, {100.0, 1.0});
    EXPECT_EQ(law.excess(), 0.0);
    for (double t = 0.0; t < 1.0; t += 0.01) EXPECT_NEAR(law.pace(t), 0.5, 1e-9);
  }
  // A hair later the curve moves, so the pace is a state: it rises to that value without stopping.
  const TimeLaw later(curve, 0.01, 3.0, 0.0, {100.0, 1.0});
  EXPECT_NEAR(later.pace(0.5), 0.5, 1e-2);
}

// A law started anywhere on another one, at its pace, loses nothing: no excess, same arrival.
TEST(TimeLaw, StartedOnItsOwnWayItGoesOnThatWay)
{
  double latest = 0.0;
  for (std::uint64_t seed = 0; seed < 400; ++seed)
  {
    SCOPED_TRACE(seed);
    Case c = randomCase(seed);
    const TimeLaw law = c.law();
    if (law.excess() > 0.0) continue;
    Rng rng(seed + 7);
    for (int trial = 0; trial < 5; ++trial)
    {
      const double elapsed = law.duration() * rng.uniform(0.0, 0.98);
      const double t = law.advance(c.from, elapsed);
      const TimeLaw rest(c.curve, t, c.to, law.pace(t), c.limits);
      ASSERT_EQ(rest.excess(), 0.0) << t;
      latest = std::max(latest, (rest.duration() + elapsed) / law.duration() - 1.0);
    }
  }
  EXPECT_LT(latest, 0.02);
  RecordProperty("latest", std::to_string(latest));
}

/// Least time over paces from a ladder at every eighth of a knot span, limits sampled: brute force.
double leastTimeOnLadder(const Case& c, double rung)
{
  const auto n = static_cast<int>(std::lround((c.to - c.from) / (0.5 * c.curve.knotSpan())));
  const double h = (c.to - c.from) / n;
  const auto rungs = static_cast<int>(1.0 / rung);
  constexpr double kNever = std::numeric_limits<double>::infinity();
  std::vector<double> time(rungs + 1, kNever);
  time[0] = 0.0;
  for (int k = n - 1; k >= 0; --k)
  {
    std::vector<double> now(rungs + 1, kNever);
    std::vector<Eigen::Vector3d> v, a;
    for (int s = 0; s <= 4; ++s)
    {
      v.push_back(c.curve.velocity(c.from + h * (k + 0.25 * s)));
      a.push_back(c.curve.acceleration(c.from + h * (k + 0.25 * s)));
    }
    for (int i = 0; i <= rungs; ++i)
      for (int j = 0; j <= rungs; ++j)
      {
        if (time[j] == kNever || i + j == 0) continue;
        const double x0 = i * rung, x1 = j * rung, w = 0.5 * (x1 - x0) / h;
        const double total = 2.0 * h / (std::sqrt(x0) + std::sqrt(x1)) + time[j];
        if (total >= now[i]) continue;
        bool kept = true;
        for (int s = 0; s <= 4 && kept; ++s)
        {
          const double x = x0 + 0.25 * s * (x1 - x0);
          kept = (v[s] * std::sqrt(x)).cwiseAbs().maxCoeff() <= c.limits.speed_mps &&
                 (a[s] * x + v[s] * w).cwiseAbs().maxCoeff() <= c.limits.acceleration_mps2;
        }
        if (kept) now[i] = total;
      }
    time = std::move(now);
  }
  return time[static_cast<int>(std::lround(std::pow(c.start_pace, 2) / rung))];
}

TEST(TimeLaw, IsAboutAsFastAsBruteForce)
{
  double slowest = 0.0;
  for (std::uint64_t seed = 0; seed < 12; ++seed)
  {
    SCOPED_TRACE(seed);
    Rng rng(seed);
    const UniformBSpline curve = weave(rng.uniform(0.5, 2.0), rng.uniform(1.0, 3.0));
    const double from = 0.2 * rng.integer(0, 20);
    const Case c{curve, from, from + 5.0, 0.0, kVehicle};
    const double brute = leastTimeOnLadder(c, 0.01);
    ASSERT_TRUE(std::isfinite(brute));
    const double ratio = c.law().duration() / brute;
    slowest = std::max(slowest, ratio);
    EXPECT_LT(ratio, 1.03);
    EXPECT_GT(ratio, 0.85);  // the ladder is coarse, not wrong
  }
  RecordProperty("slowest", std::to_string(slowest));
}

TEST(TimeLaw, DegenerateStretches)
{
  const UniformBSpline curve = weave(0.7, 0.6, 3.0);
  for (const double t : {curve.start(), 5.0, curve.end()})
  {
    const TimeLaw nothing(curve, t, t, 0.0, kVehicle);
    EXPECT_EQ(nothing.duration(), 0.0);
    EXPECT_EQ(nothing.advance(t, 1.0), t);
    EXPECT_EQ(nothing.pace(t), 0.0);
    EXPECT_EQ(nothing.paceChange(t), 0.0);
    EXPECT_EQ(nothing.excess(), 0.0);
    EXPECT_EQ(TimeLaw(curve, t, t, 0.5, kVehicle).excess(),
              std::numeric_limits<double>::infinity());
  }
  const TimeLaw outside(curve, -10.0, 100.0, 0.0, kVehicle);
  EXPECT_EQ(outside.from(), curve.start());
  EXPECT_EQ(outside.to(), curve.end());
  EXPECT_EQ(outside.pace(-10.0), outside.pace(curve.start()));
  EXPECT_EQ(outside.pace(100.0), 0.0);
  EXPECT_EQ(outside.advance(-10.0, 1e6), curve.end());
  const TimeLaw beyond(curve, 100.0, 50.0, 0.0, kVehicle);
  EXPECT_EQ(beyond.from(), curve.end());
  EXPECT_EQ(beyond.duration(), 0.0);

  const UniformBSpline still(Eigen::Matrix3Xd::Ones(3, 9), 0.2);
  const TimeLaw wait(still, 0.1, 1.0, 0.0, kVehicle);
  EXPECT_EQ(wait.excess(), 0.0);
  EXPECT_NEAR(wait.duration(), 0.9, 1e-12);
  EXPECT_NEAR(wait.advance(0.1, 0.3), 0.4, 1e-12);
}

TEST(TimeLaw, StretchesThatBeginOrEndNextToAKnot)
{
  const Case whole{weave(1.0, 2.0), 0.0, 8.0, 0.0, kVehicle};
  for (const double knot : {1.0, 1.05, 3.2})
    for (double beside = 1e-16; beside < 0.1; beside *= 10.0)
      for (const double sign : {-1.0, 1.0})
      {
        SCOPED_TRACE(sign * beside);
        Case c = whole;
        c.from = knot + sign * beside;
        c.to = knot + 4.0 - sign * 0.7 * beside;
        const TimeLaw law = c.law();
        EXPECT_EQ(law.excess(), 0.0);
        for (const double t : denseTimes(c)) ASSERT_LE(worstRatio(c, law, t), 1.0 + 1e-5) << t;
        EXPECT_NEAR(law.duration(), TimeLaw(c.curve, knot, knot + 4.0, 0.0, kVehicle).duration(),
                    0.01 + 4.0 * std::sqrt(beside));
        Case sliver{c.curve, knot, knot + beside, 0.0, kVehicle};
        const TimeLaw short_law = sliver.law();
        EXPECT_TRUE(std::isfinite(short_law.duration()));
        EXPECT_EQ(short_law.advance(knot, 10.0), sliver.to);
      }
}

TEST(TimeLaw, TinyLimitsAreKeptInFiniteTime)
{
  for (const double tiny : {1e-3, 1e-6, 1e-9})
    for (const MotionLimits limits :
         {MotionLimits{tiny, 1.0}, MotionLimits{1.2, tiny}, MotionLimits{tiny, tiny}})
    {
      SCOPED_TRACE(tiny);
      const Case c{weave(1.0, 2.0), 1.0, 9.0, 0.0, limits};
      const TimeLaw law = c.law();
      EXPECT_EQ(law.excess(), 0.0);
      EXPECT_TRUE(std::isfinite(law.duration()));
      EXPECT_GT(law.duration(), 8.0);
      for (const double t : denseTimes(c)) ASSERT_LE(worstRatio(c, law, t), 1.0 + 1e-5) << t;
      EXPECT_EQ(law.advance(c.from, law.duration()), c.to);
    }
}

TEST(TimeLaw, RefusesWhatIsNoLimit)
{
  const UniformBSpline curve = straight(1.0);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double inf = std::numeric_limits<double>::infinity();
  const auto make = [&](double from, double to, double pace, MotionLimits limits)
  { (void)TimeLaw(curve, from, to, pace, limits); };
  EXPECT_NO_THROW(make(0, 1, 0, kVehicle));
  for (const double bad : {0.0, -1.0, nan, inf})
  {
    EXPECT_THROW(make(0, 1, 0, {bad, 1.0}), std::invalid_argument);
    EXPECT_THROW(make(0, 1, 0, {1.0, bad}), std::invalid_argument);
  }
  for (const double bad : {nan, inf, -inf})
  {
    EXPECT_THROW(make(bad, 1, 0, kVehicle), std::invalid_argument);
    EXPECT_THROW(make(0, bad, 0, kVehicle), std::invalid_argument);
    EXPECT_THROW(make(0, 1, bad, kVehicle), std::invalid_argument);
  }
}

}  // namespace
}  // namespace slalom::spline
