// SPDX-License-Identifier: BSD-3-Clause
// What is at rest is never called a mover: it would vanish from the map.
#include <gtest/gtest.h>

#include <algorithm>

#include "MovingScene.h"
#include "slalom/tracking/MoverTracker.h"

namespace
{
using slalom::core::Rng;
using slalom::test::difficultForest;
using slalom::test::MovingBody;
using slalom::test::SpinningLidar;
using slalom::test::StaticScene;
using slalom::tracking::MoverTracker;
using slalom::tracking::TrackingConfig;
using Vec3 = Eigen::Vector3d;

struct Flight
{
  double speed = 1.0;
  int parts = 1;  ///< in which a turn of the lidar arrives
  int azimuths = 600;
  double jump_m = 0.0;  ///< of the estimated position, once
  int scans = 60;
  std::vector<MovingBody> bodies = {};
};

struct Count
{
  int scans = 0, with_movers = 0, masked = 0, objects = 0;
};

Count fly(std::uint64_t seed, const StaticScene& scene, const Flight& flight)
{
  Rng rng(seed);
  SpinningLidar lidar;
  lidar.azimuths = flight.azimuths;
  MoverTracker tracker{TrackingConfig{}};
  Vec3 p(-0.05 * flight.scans * flight.speed, 0.0, 1.5);
  const double weave = rng.uniform(0.2, 0.7);
  Count count;
  for (int k = 0; k < flight.scans * flight.parts; ++k)
  {
    const double t = 0.1 * k / flight.parts;
    const int part = k % flight.parts;
    const Vec3 v(flight.speed, 0.5 * std::sin(weave * t), 0.2 * std::cos(0.4 * t));
    const Eigen::Vector2d tilt(0.1 * std::sin(1.3 * t), 0.1 * std::cos(0.9 * t));
    auto rays = lidar.scan(scene, flight.bodies, rng, t - 0.1 * part / flight.parts, p, v, tilt,
                           double(part) / flight.parts, double(part + 1) / flight.parts);
    const bool jumped = k >= flight.scans * flight.parts / 2;
    const Vec3 off = (jumped ? flight.jump_m : 0.0) * Vec3(0.8, 0.6, 0.0);
    for (auto& ray : rays) ray.origin_L += off.cast<float>(), ray.end_L += off.cast<float>();
    const auto output = tracker.update(t, p + off, rays, nullptr);
    ++count.scans;
    count.objects += output.objects;
    count.with_movers += !output.movers.empty();
    count.masked += std::count(output.on_mover.begin(), output.on_mover.end(), 1) > 0;
    p += 0.1 / flight.parts * v;
  }
  return count;
}

Count fly(std::uint64_t first, int seeds, const Flight& flight)
{
  Count all;
  for (std::uint64_t seed = first; seed < first + static_cast<std::uint64_t>(seeds); ++seed)
  {
    SCOPED_TRACE(seed);
    const Count one = fly(seed, difficultForest(seed, 12.0 + 0.05 * flight.scans, 12.0), flight);
    EXPECT_EQ(one.with_movers, 0);
    all.scans += one.scans;
    all.with_movers += one.with_movers;
    all.masked += one.masked;
    all.objects += one.objects;
  }
  // There was something to be mistaken about, and the suspicion is rare as well.
  EXPECT_GT(all.objects, all.scans);
  EXPECT_LT(all.masked, 1 + all.scans / 50);
  return all;
}

TEST(StaticWorld, NothingMovesForAFlyingVehicle)
{
  fly(1, 4, {.speed = 1.0});
  fly(20, 4, {.speed = 2.0});
}

TEST(StaticWorld, NothingMovesForAHoveringVehicle)
{
  fly(40, 4, {.speed = 0.0});
}

TEST(StaticWorld, NothingMovesWhenTurnsArriveInParts)
{
  fly(60, 3, {.speed = 1.2, .parts = 4});
}

TEST(StaticWorld, NothingMovesForACoarseLidar)
{
  fly(80, 6, {.speed = 1.0, .azimuths = 240});
}

TEST(StaticWorld, NothingMovesWhenTheEstimatedPositionJumps)
{
  fly(100, 3, {.speed = 1.0, .jump_m = 0.4});
  fly(110, 3, {.speed = 1.0, .jump_m = 1.0});
}

// The same flights are not blind: somebody who walks through them is seen.
TEST(StaticWorld, SomebodyInTheSameForestDoesMove)
{
  int seen = 0;
  for (std::uint64_t seed = 1; seed < 5; ++seed)
  {
    StaticScene scene = difficultForest(seed, 15.0, 12.0);
    std::erase_if(scene.trunks,
                  [](const auto& trunk) { return std::fabs(trunk.centre.y()) < 1.6; });
    Flight flight;
    flight.bodies = {MovingBody{Vec3(4.0, 0.6, 0.9), Vec3(-0.8, 0.0, 0.0), 0.2, 0.9}};
    seen += fly(seed, scene, flight).with_movers > 10;
  }
  EXPECT_EQ(seen, 4);
}

}  // namespace
