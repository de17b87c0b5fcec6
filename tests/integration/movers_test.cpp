// SPDX-License-Identifier: BSD-3-Clause
// Somebody walks through the map: with the tracker no trail of him stays, without it one does.
// Somebody walks into a vehicle that stands: it steps aside.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <numbers>

#include "FlightHarness.h"
#include "MovingScene.h"
#include "slalom/mapping/Mapper.h"
#include "slalom/tracking/MoverTracker.h"

namespace
{
using namespace slalom;
using Vec3 = Eigen::Vector3d;

// Occupied voxels on the way of a body, at least `behind` seconds behind it, summed over all scans.
int trail(std::uint64_t seed, double speed, bool tracked, double behind, int& on_trees)
{
  core::Rng rng(seed);
  test::StaticScene scene;
  for (int i = 0; i < 30; ++i)
    scene.trunks.push_back({{rng.uniform(-6.0, 10.0), (i % 2 ? 1 : -1) * rng.uniform(3.5, 9.0)},
                            rng.uniform(0.15, 0.4)});
  for (int i = 0; i < 12; ++i) scene.trunks.push_back({{12.0, 1.5 * i - 9.0}, 0.9});
  const test::MovingBody body{Vec3(3.5, -2.8, 0.9), Vec3(0, speed, 0), 0.2, 0.9, 0.0};
  test::SpinningLidar lidar;
  lidar.azimuths = 900;
  mapping::Mapper mapper{mapping::MapperConfig{}};
  tracking::MoverTracker tracker{tracking::TrackingConfig{}};
  const Vec3 v(0.3, 0, 0);
  int left = 0;
  for (int k = -23; 0.1 * k * speed < 5.6; ++k)
  {
    const double t = 0.1 * k;
    const Vec3 p = Vec3(0, 0, 1.5) + t * v;
    const auto rays = lidar.scan(scene, {body}, rng, t, p, v);
    if (tracked)
    {
      const auto map = mapper.snapshot();
      const auto out = tracker.update(t, p, rays, map.get());
      mapper.integrate(t, p, rays, {out.on_mover, out.ghosts});
    }
    else
      mapper.integrate(t, p, rays);
    std::vector<Vec3> occupied;
    mapper.snapshot()->collectObstacles(mapper.snapshot()->bounds(), core::UnknownAs::Free,
                                        occupied);
    on_trees = 0;
    for (const Vec3& c : occupied)
    {
      const double along = (c.y() - body.start.y()) / speed;  // [s] when he was there
      // Confirmed by then, and above the ground.
      const bool on_way = std::fabs(c.x() - body.start.x()) < 0.4 && c.z() > 0.3 && c.z() < 1.9 &&
                          along > -0.2 / speed && along < t - behind && c.y() < 2.8;
      left += on_way && t > 2.5;
      on_trees += std::fabs(c.y()) > 3.2 && c.z() > 0.3;
    }
  }
  return left;
}

TEST(Movers, LeaveNoTrailInTheMapOneSecondBehindThem)
{
  int without = 0;
  for (const double speed : {0.6, 1.0, 1.5})
    for (const std::uint64_t seed : {1})
    {
      SCOPED_TRACE(testing::Message() << speed << " m/s, seed " << seed);
      int trees = 0, trees_plain = 0;
      const int with = trail(seed, speed, true, 1.0, trees);
      const int plain = trail(seed, speed, false, 1.0, trees_plain);
      EXPECT_EQ(with, 0);
      EXPECT_GT(trees, 0.97 * trees_plain);
      without += plain;
      RecordProperty("trail_" + std::to_string(speed) + "_" + std::to_string(seed),
                     std::to_string(with) + " plain " + std::to_string(plain));
      std::printf("%.1f m/s: %d voxel scans of trail, %d without tracker; trees %d of %d\n", speed,
                  with, plain, trees, trees_plain);
    }
  EXPECT_GT(without, 0);
}

/// Somebody of 1.8 m who walks straight on over the ground.
struct Walker
{
  static constexpr double kRadius = 0.3, kHeight = 1.8;
  Eigen::Vector2d meets;  ///< [m]
  double meets_at;        ///< [s]
  Eigen::Vector2d v;      ///< [m/s]

  [[nodiscard]] double distance(const Vec3& p, double t) const
  {
    const Eigen::Vector2d place = meets + (t - meets_at) * v;
    const double planar = (p.head<2>() - place).norm() - kRadius, above = p.z() - kHeight;
    return std::max(planar, above) < 0.0 ? std::max(planar, above)
                                         : std::hypot(std::max(planar, 0.0), std::max(above, 0.0));
  }
};

Eigen::Vector2d towards(double course)
{
  return {std::cos(course), std::sin(course)};
}

struct Visit
{
  double gap = 1e9;     // [m] between the surfaces of vehicle and walkers
  double fixed = 1e9;   // [m] to what stands
  double lowest = 1e9;  // [m]
};

/// A vehicle flies one metre and stands at its goal, or waits before somebody who crosses slowly;
/// then somebody walks into it from anywhere.
Visit visit(std::uint64_t seed, bool waiting, bool evade)
{
  core::Rng rng(seed);
  const Eigen::Vector2d place(waiting ? 1.8 : 1.0, 0.0);
  const double speed = rng.uniform(0.3, 1.2), course = rng.uniform(0.0, 2.0 * std::numbers::pi);
  const double miss = rng.uniform(-0.3, 0.3), at = rng.uniform(9.0, 12.0);
  std::vector<Walker> walkers{
      {place + miss * towards(course + 0.5 * std::numbers::pi), at, speed * towards(course)}};
  if (waiting) walkers.push_back({{4.0, 0.0}, 8.0, {0.0, 0.3}});
  std::vector<test::Obstacle> standing{Eigen::AlignedBox3d(Vec3(-30, -30, -1), Vec3(30, 30, 0))};
  while (standing.size() < 6)
  {
    const Eigen::Vector2d centre(rng.uniform(-5.0, 8.0), rng.uniform(-5.0, 5.0));
    if ((centre - place).norm() > 2.2 && centre.norm() > 1.5)
      standing.push_back(test::VerticalCylinder{centre, rng.uniform(0.2, 0.4)});
  }
  const test::AnalyticField court(std::move(standing));
  double now = 0.0;
  const auto distance = [&](const Vec3& p)
  {
    double least = court.signedDistance(p);
    for (const Walker& walker : walkers) least = std::min(least, walker.distance(p, now));
    return least;
  };
  engine::EngineConfig config = test::flightConfig();
  config.safety.evade = evade;
  test::FlightHarness harness(test::FlightWorld::of(distance), config);
  harness.azimuths = 360;
  harness.over = [](double, engine::EngineStatus) { return false; };
  Visit result;
  harness.faults.world = [&](double t, const Vec3& p)
  {
    now = t;
    for (const Walker& walker : walkers)
      result.gap = std::min(result.gap, walker.distance(p, t) - config.vehicle.radius_m);
    result.fixed = std::min(result.fixed, court.signedDistance(p) - config.vehicle.radius_m);
    result.lowest = std::min(result.lowest, p.z());
  };
  engine::Mission mission;
  mission.waypoints_W = Vec3(waiting ? 9.0 : 1.0, 0.0, 1.2);
  harness.fly(Vec3(0.0, 0.0, 1.2), mission, at + 4.0);
  return result;
}

TEST(Movers, AVehicleThatStandsStepsAsideForWhoWalksIntoIt)
{
  int flights = 0, hit = 0, hit_without = 0;
  double least = 1e9;
  for (std::uint64_t seed = 1; seed <= 12; ++seed)
  {
    const bool waiting = seed % 4 == 0;
    SCOPED_TRACE(testing::Message() << "seed " << seed << (waiting ? ", waiting" : ""));
    const Visit with = visit(seed, waiting, true);
    std::printf("seed %d: gap %.2f m, to what stands %.2f m, lowest %.2f m\n",
                static_cast<int>(seed), with.gap, with.fixed, with.lowest);
    EXPECT_GE(with.gap, 0.0);
    EXPECT_GE(with.fixed, 0.0);
    EXPECT_GE(with.lowest, global_planner::GlobalPlannerConfig{}.min_altitude_m);
    hit += with.gap < 0.0;
    if (seed <= 6) hit_without += visit(seed, waiting, false).gap < 0.0;
    least = std::min(least, with.gap);
    ++flights;
  }
  std::printf("%d of %d are hit, least gap %.2f m; without stepping aside %d of 6\n", hit, flights,
              least, hit_without);
  EXPECT_GE(hit_without, 1);
}

}  // namespace
