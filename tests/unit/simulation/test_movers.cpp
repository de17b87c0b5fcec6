// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "TempFile.h"
#include "slalom/core/Rng.h"
#include "slalom/simulation/SimulatedFlight.h"
#include "slalom/simulation/World.h"

namespace slalom::simulation
{
namespace
{
using Eigen::Vector3d;
using testing::HasSubstr;

MoverPath anyPath(core::Rng& rng)
{
  MoverPath path;
  path.delay_s = rng.uniform(-3.0, 3.0);
  path.speed = rng.uniform(0.3, 2.0);
  path.at_end = static_cast<AtEnd>(rng.integer(0, 2));
  if (rng.uniform() < 0.5)
    for (int k = rng.integer(2, 5); k > 0; --k) path.waypoints_W.push_back(rng.uniform3(-4.0, 4.0));
  path.start_W = rng.uniform3(-3.0, 3.0);
  path.velocity_W = rng.uniform3(-1.0, 1.0);
  path.amplitude_W = rng.uniform3(-1.0, 1.0);
  path.period_s = rng.uniform(2.0, 8.0);
  return path;
}

/// No path jumps, walkers keep their speed between corners, and nothing moves before its delay.
TEST(MoverPath, IsContinuousAndKeepsItsSpeed)
{
  for (std::uint64_t seed = 1; seed <= 100; ++seed)
  {
    SCOPED_TRACE(seed);
    core::Rng rng(seed);
    const MoverPath path = anyPath(rng);
    const bool walks = !path.waypoints_W.empty();
    const double fastest = walks ? path.speed
                                 : path.velocity_W.norm() + 2.0 * std::numbers::pi / path.period_s *
                                                                path.amplitude_W.norm();
    constexpr double kStep = 0.01;
    int at_speed = 0, moving = 0;
    for (double t = 0.0; t < 40.0; t += kStep)
    {
      const double moved = (path.at(t + kStep) - path.at(t)).norm();
      ASSERT_LE(moved, fastest * kStep * (1.0 + 1e-9) + 1e-12) << t;
      ASSERT_TRUE(moved == 0.0 || t + kStep >= path.delay_s);
      moving += moved > 0.0;
      at_speed += std::abs(moved - path.speed * kStep) < 1e-9;
    }
    if (walks && path.at_end != AtEnd::Stop)
    {
      EXPECT_GT(moving, 3600);
      EXPECT_GT(at_speed, moving * 9 / 10);
    }
  }
}

TEST(MoverPath, VisitsItsWaypointsAndEndsAsAsked)
{
  MoverPath path;
  path.waypoints_W = {Vector3d(0, 0, 0), Vector3d(3, 0, 0), Vector3d(3, 4, 0)};  // 3 + 4 m
  path.speed = 2.0;
  const auto at = [&](AtEnd end, double way)
  {
    path.at_end = end;
    return path.at(way / path.speed);
  };
  for (const AtEnd end : {AtEnd::Stop, AtEnd::Return, AtEnd::Loop})
  {
    EXPECT_LT((at(end, 3.0) - Vector3d(3, 0, 0)).norm(), 1e-9);
    EXPECT_LT((at(end, 5.0) - Vector3d(3, 2, 0)).norm(), 1e-9);
  }
  EXPECT_LT((at(AtEnd::Stop, 100.0) - Vector3d(3, 4, 0)).norm(), 1e-9);
  EXPECT_LT((at(AtEnd::Return, 9.0) - Vector3d(3, 2, 0)).norm(), 1e-9);
  EXPECT_LT((at(AtEnd::Return, 14.0) - Vector3d(0, 0, 0)).norm(), 1e-9);
  EXPECT_LT((at(AtEnd::Loop, 9.5) - Vector3d(1.5, 2, 0)).norm(), 1e-9) << "5 m back to the first";
  EXPECT_LT((at(AtEnd::Loop, 13.0) - Vector3d(1, 0, 0)).norm(), 1e-9);
}

Mover anyMover(core::Rng& rng)
{
  Mover mover;
  mover.radius = rng.uniform(0.2, 0.8);
  mover.height = rng.uniform() < 0.5 ? 0.0 : rng.uniform(1.0, 2.0);
  mover.path.start_W = rng.uniform3(-3.0, 3.0);
  mover.path.velocity_W = rng.uniform3(-1.0, 1.0);
  return mover;
}

/// At any time the movers are solid exactly where spheres and cylinders that stand there would be.
TEST(MoversAt, AreWhatStandsThereAtThatTime)
{
  for (std::uint64_t seed = 1; seed <= 40; ++seed)
  {
    SCOPED_TRACE(seed);
    core::Rng rng(seed);
    std::vector<Mover> movers;
    for (int k = rng.integer(1, 6); k > 0; --k) movers.push_back(anyMover(rng));
    const double t = rng.uniform(0.0, 5.0);
    Shapes frozen;
    frozen.ground = false;
    for (const Mover& mover : movers)
    {
      const Vector3d p = mover.path.at(t);
      if (mover.height > 0.0)
        frozen.trees.push_back({p.head<2>(), mover.radius, mover.height, p.z()});
      else
        frozen.spheres.push_back({p, mover.radius});
    }
    const World still = World::of(std::move(frozen));
    const MoversAt moving(movers, t);
    int hits = 0;
    for (int k = 0; k < 200; ++k)
    {
      const Vector3d p = rng.uniform3(-6.0, 6.0);
      const Vector3d aim = movers.front().path.at(t) + rng.normal3(0.5);
      const Vector3d direction = (k % 2 == 0 ? rng.direction() : aim - p).normalized();
      ASSERT_NEAR(moving.distance(p), still.distance(p), 1e-12);
      const auto a = moving.castRay(p, direction, 9.0), b = still.castRay(p, direction, 9.0);
      ASSERT_EQ(a.has_value(), b.has_value());
      if (!a) continue;
      ++hits;
      ASSERT_NEAR(*a, *b, 1e-9);
      ASSERT_LE(moving.distance(p + *a * direction), 1e-9) << "the hit is on the surface";
    }
    EXPECT_GT(hits, 5);
  }
}

const char* const kWorld = R"(
[world]
ground = true
[cylinder.pole]
x = 1
y = 2
base = 1.0
radius = 0.2
height = 2
[sphere.ball]
centre = 4, 0, 1.5
radius = 0.5
[mover.walker]
radius = 0.3
height = 1.8
waypoints = 0,0,0 | 3,0,0 | 3,4,0
speed = 1
at_end = loop
[mover.drone]
radius = 0.4
start = 0, 0, 2
velocity = 0.5, 0, 0
amplitude = 0, 1, 0
period_s = 4
jitter_s = 2
)";

TEST(World, ReadsCylindersSpheresAndMovers)
{
  const test::TempFile file("world.ini", kWorld);
  const World world = World::load(file.path(), 3);
  EXPECT_NEAR(world.distance({1.0, 2.0, 0.5}), 0.5, 1e-12) << "below the pole's foot";
  EXPECT_NEAR(world.distance({2.0, 2.0, 2.0}), 0.8, 1e-12);
  EXPECT_NEAR(world.distance({4.0, 0.0, 3.0}), 1.0, 1e-12);
  ASSERT_EQ(world.movers().size(), 2u);
  const Mover &drone = world.movers()[0], &walker = world.movers()[1];  // in order of names
  EXPECT_EQ(walker.name, "walker");
  EXPECT_EQ(walker.height, 1.8);
  EXPECT_LT((walker.path.at(5.0) - Vector3d(3, 2, 0)).norm(), 1e-9);
  EXPECT_EQ(drone.height, 0.0);
  EXPECT_LE(std::abs(drone.path.delay_s), 2.0);
  EXPECT_EQ(World::load(file.path(), 3).movers()[0].path.delay_s, drone.path.delay_s);
  EXPECT_NE(World::load(file.path(), 4).movers()[0].path.delay_s, drone.path.delay_s);
  EXPECT_EQ(World::load(file.path(), 4).movers()[1].path.delay_s, 0.0);
}

TEST(World, NamesWhatIsWrongWithAMover)
{
  const auto message = [](const std::string& text)
  {
    const test::TempFile file("bad.ini", text);
    return test::messageOf([&] { (void)World::load(file.path()); });
  };
  EXPECT_THAT(message("[mover.a]\nradius=0.3\n"), HasSubstr("start"));
  EXPECT_THAT(message("[mover.a]\nradius=0\nstart=0,0,0\n"), HasSubstr("radius"));
  EXPECT_THAT(message("[mover.a]\nradius=1\nwaypoints=0,0,0\nspeed=1\n"), HasSubstr("two points"));
  EXPECT_THAT(message("[mover.a]\nradius=1\nwaypoints=0,0|1,1,1\nspeed=1\n"), HasSubstr("x,y,z"));
  EXPECT_THAT(message("[mover.a]\nradius=1\nwaypoints=0,0,0|1,1,1\nspeed=1\nat_end=x\n"),
              HasSubstr("at_end"));
  EXPECT_THAT(message("[mover.a]\nradius=1\nstart=0,0,0\nspede=1\n"), HasSubstr("spede"));
  EXPECT_THAT(message("[mover.a]\nradius=1\nstart=0,0,0\namplitude=0,1,0\nperiod_s=-1\n"),
              HasSubstr("period_s"));
}

SensorSuite fewRays()
{
  SensorSuite suite;
  suite.lidar.record_every = 5;
  return suite;
}

/// A ball that flies by a vehicle that hovers: the truth knows how near it came, and of a hit.
FlightTruth passedBy(double offset)
{
  Shapes shapes;
  Mover ball;
  ball.radius = 0.4;
  ball.path.start_W = {-3.0, offset, 1.5};
  ball.path.velocity_W = {2.0, 0.0, 0.0};
  shapes.movers = {ball};
  const World world = World::of(std::move(shapes));
  SimulatedFlight flight(world, {}, fewRays(), {{0.0, 0.0, 1.5}, 0.0, 0.35}, 1);
  for (int k = 0; k < 60; ++k) (void)flight.advance(0.05, {});
  return flight.truth();
}

TEST(SimulatedFlight, CountsMovers)
{
  const FlightTruth past = passedBy(1.0);
  EXPECT_NEAR(past.nearest_mover.distance, 0.6, 1e-3);
  EXPECT_NEAR(past.nearest_mover.t, 1.5, 0.01);
  EXPECT_EQ(past.nearest.distance, past.nearest_mover.distance);
  EXPECT_FALSE(past.first_contact);

  const FlightTruth hit = passedBy(0.74);
  ASSERT_TRUE(hit.first_contact);
  EXPECT_TRUE(hit.hit_mover);
  EXPECT_EQ(hit.contacts, 1u);
  EXPECT_FALSE(passedBy(0.76).first_contact);
}

TEST(SimulatedFlight, MeasuresEffortAndClearances)
{
  const World world = World::of({{{0.0, 1.0}, 0.3, 6.0}}, {}, true);
  AirframeConfig lag;
  lag.model = AirframeModel::Lag;
  lag.drag_per_s = lag.command_delay_s = 0.0;
  SimulatedFlight flight(world, lag, fewRays(), {{0.0, 0.0, 1.5}, 0.0, 0.35}, 1);
  (void)flight.advance(1.0, {});
  EXPECT_NEAR(flight.truth().clearances.quantile(0.5), 0.7, ClearanceHistogram::kBin + 1e-9);
  EXPECT_EQ(flight.truth().acceleration_effort, 0.0);
  (void)flight.advance(4.0, {{0.0, -1.0, 0.0}, 0.0});
  // a = exp(-t / lag) / lag: the integral of its square is 1 / (2 lag), of a step of 5 ms less 1 %.
  const FlightTruth& truth = flight.truth();
  EXPECT_NEAR(truth.acceleration_effort, 0.5 / lag.velocity_lag_s, 0.02);
  EXPECT_GT(truth.jerk_effort,
            truth.acceleration_effort / (lag.velocity_lag_s * lag.velocity_lag_s));
  const double p05 = truth.clearances.quantile(0.05), p95 = truth.clearances.quantile(0.95);
  EXPECT_NEAR(p05, 0.7, ClearanceHistogram::kBin + 1e-9);
  EXPECT_NEAR(p95, 0.7 + 4.0 - lag.velocity_lag_s - 0.25, 0.05) << "the last 5 % of 5 s";
  EXPECT_TRUE(std::isnan(ClearanceHistogram().quantile(0.5)));
}
}  // namespace
}  // namespace slalom::simulation
