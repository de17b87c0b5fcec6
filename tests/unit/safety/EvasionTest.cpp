// SPDX-License-Identifier: BSD-3-Clause
// Who stands where something walks steps aside, and hits nothing that stands while doing so.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <numbers>

#include "GateFlight.h"

namespace
{
using namespace slalom;
using safety::GateInput;
using safety::GateOutput;
using safety::Intervention;
using Vec3 = Eigen::Vector3d;

constexpr double kBody = 0.3;  // [m] radius of who walks

/// Walks straight on; is known with a margin of 0.1 m, as the tracker adds.
core::MovingObstacle walker(const Vec3& p, const Vec3& v)
{
  return {.id = 1,
          .p_L = p,
          .v_L = v,
          .radius_m = kBody + 0.1,
          .half_axis_m = 0.9,
          .sigma_p_m = 0.05,
          .sigma_v_mps = 0.08};
}

/// A walker who comes from `course` and would pass the origin at `miss`, `away` from it at t = 0.
core::MovingObstacle towardsOrigin(double course, double speed, double away, double miss)
{
  const Vec3 from(std::cos(course), std::sin(course), 0.0), side(-from.y(), from.x(), 0.0);
  return walker(away * from + miss * side, -speed * from);
}

struct Least
{
  double mover = 1e9, fixed = 1e9;  // [m] beyond the radius
  double low = 1e9, high = -1e9;    // [m] altitude
};

/// The vehicle wants nothing but to stand.
Least stand(test::GateFlight& flight, const safety::SafetyConfig& config,
            std::span<const core::MovingObstacle> movers, double seconds)
{
  const safety::OutputGate gate(config, flight.vehicle);
  Least least;
  safety::Evasion kept;
  while (flight.t < seconds)
  {
    GateInput in = flight.input();
    in.movers = movers;
    in.kept_evasion = kept;
    const GateOutput out = gate.pass(in);
    kept = out.evasion;
    flight.obey(out.command);
    for (const core::MovingObstacle& mover : movers)
      least.mover = std::min(
          least.mover, (mover.nearest(flight.motion.p, flight.t) - flight.motion.p).norm() - kBody -
                           flight.vehicle.radius_m);
    least.low = std::min(least.low, flight.motion.p.z());
    least.high = std::max(least.high, flight.motion.p.z());
  }
  least.fixed = flight.least_clearance_m;
  return least;
}

safety::SafetyConfig evading(bool evade)
{
  safety::SafetyConfig config;
  config.evade = evade;
  config.fence_min_z_m = -0.9;
  config.fence_max_z_m = 1.5;
  return config;
}

TEST(Evasion, WhoStandsStepsAsideForWhoWalksIntoHim)
{
  int hit_without = 0, trials = 0;
  double least = 1e9;
  for (std::uint64_t seed = 1; seed <= 80; ++seed)
  {
    SCOPED_TRACE(seed);
    core::Rng rng(seed);
    test::GateFlight flight;
    flight.true_lag_s = rng.uniform(0.15, 0.25);
    flight.field = test::makeForest(rng, 6, 1.2);
    const core::MovingObstacle mover =
        towardsOrigin(rng.uniform(0.0, 2.0 * std::numbers::pi), rng.uniform(0.3, 1.2), 5.0,
                      rng.uniform(-0.4, 0.4));
    test::GateFlight other = flight;
    const Least with = stand(flight, evading(true), std::span(&mover, 1), 25.0);
    const Least without = stand(other, evading(false), std::span(&mover, 1), 25.0);
    EXPECT_GE(with.mover, 0.0);
    EXPECT_GE(with.fixed, -1e-6);
    EXPECT_GE(with.low, -0.9);
    EXPECT_LE(with.high, 1.5);
    least = std::min(least, with.mover);
    hit_without += without.mover < 0.0;
    ++trials;
  }
  std::printf("stepping aside: least gap %.2f m; without it %d of %d are hit\n", least, hit_without,
              trials);
  EXPECT_GE(hit_without, trials / 2) << "the encounters must be real";
}

TEST(Evasion, NorIsItHitByTwoAtOnce)
{
  int hit = 0, hit_without = 0;
  for (std::uint64_t seed = 1; seed <= 40; ++seed)
  {
    core::Rng rng(seed);
    test::GateFlight flight;
    flight.field = test::makeForest(rng, 3, 1.5);
    const double course = rng.uniform(0.0, 2.0 * std::numbers::pi);
    const core::MovingObstacle movers[] = {
        towardsOrigin(course, rng.uniform(0.3, 1.0), 5.0, rng.uniform(-0.3, 0.3)),
        towardsOrigin(course + rng.uniform(0.8, 5.5), rng.uniform(0.3, 1.0), 5.0,
                      rng.uniform(-0.3, 0.3))};
    test::GateFlight other = flight;
    const Least with = stand(flight, evading(true), movers, 25.0);
    EXPECT_GE(with.fixed, -1e-6) << seed;
    hit += with.mover < 0.0;
    hit_without += stand(other, evading(false), movers, 25.0).mover < 0.0;
  }
  std::printf("two at once: %d of 40 are hit, %d without stepping aside\n", hit, hit_without);
  EXPECT_EQ(hit, 0);
  EXPECT_GE(hit_without, 25);
}

/// Where there is no room it stays: a wall is not hit to dodge somebody.
TEST(Evasion, WhatStandsIsNotHitToDodge)
{
  for (std::uint64_t seed = 1; seed <= 30; ++seed)
  {
    SCOPED_TRACE(seed);
    core::Rng rng(seed);
    test::GateFlight flight;
    flight.true_lag_s = rng.uniform(0.2, 0.25);
    // A blind alley, open to where the walker comes from.
    const double half = 0.35 + rng.uniform(0.0, 0.6);
    const auto wall = [](double x0, double y0, double x1, double y1)
    { return Eigen::AlignedBox3d(Vec3(x0, y0, -3.0), Vec3(x1, y1, 3.0)); };
    flight.field = std::make_shared<const test::AnalyticField>(std::vector<test::Obstacle>{
        wall(-1.5, -half - 0.2, 4.0, -half), wall(-1.5, half, 4.0, half + 0.2),
        wall(-1.5, -half, -1.5 + 0.2, half)});
    const core::MovingObstacle mover =
        towardsOrigin(0.0, rng.uniform(0.3, 1.2), 5.0, rng.uniform(-0.2, 0.2));
    EXPECT_GE(stand(flight, evading(true), std::span(&mover, 1), 15.0).fixed, -1e-6);
  }
}

TEST(Evasion, OnlyWhoMayMoveMovesAndOnlyWhereTheMapIsKnown)
{
  const core::MovingObstacle mover = towardsOrigin(0.5, 1.2, 1.2, 0.05);
  test::GateFlight flight;
  flight.field = std::make_shared<const test::AnalyticField>(std::vector<test::Obstacle>{});
  const safety::OutputGate gate({}, flight.vehicle);
  const auto command = [&](auto change)
  {
    GateInput in = flight.input();
    in.movers = std::span(&mover, 1);
    change(in);
    return gate.pass(in);
  };
  const GateOutput aside = command([](GateInput&) {});
  EXPECT_EQ(aside.intervention, Intervention::MovingObstacle);
  EXPECT_GT(aside.command.v_W.norm(), 0.04);
  EXPECT_GT(aside.evasion.for_s, 0.0);
  EXPECT_TRUE(command([](GateInput& in) { in.may_evade = false; }).command.v_W.isZero());
  EXPECT_TRUE(command([](GateInput& in) { in.map_age_s = 5.0; }).command.v_W.isZero());
  EXPECT_TRUE(command(
                  [](GateInput& in)
                  {
                    in.field = nullptr;
                    in.needs_map = false;
                  })
                  .command.v_W.isZero());
}

/// Both walk beside the vehicle's place, no nearer than the uncertainty of two seconds.
TEST(Evasion, WhoIsPassedStaysWhereHeIs)
{
  for (const double miss : {-1.5, 1.5})
  {
    test::GateFlight flight;
    flight.field = std::make_shared<const test::AnalyticField>(std::vector<test::Obstacle>{});
    const core::MovingObstacle mover = towardsOrigin(1.0, 0.8, 5.0, miss);
    stand(flight, evading(true), std::span(&mover, 1), 12.0);
    EXPECT_LE(flight.motion.p.norm(), 1e-9);
  }
}

}  // namespace
