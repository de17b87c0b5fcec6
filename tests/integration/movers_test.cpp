// SPDX-License-Identifier: BSD-3-Clause
// Somebody walks through the map: with the tracker no trail of him stays, without it one does.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

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

}  // namespace
