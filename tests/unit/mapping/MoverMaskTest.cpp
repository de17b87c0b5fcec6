// SPDX-License-Identifier: BSD-3-Clause
// Laws of keeping movers out of the map.
#include <gtest/gtest.h>
#include <octomap/OcTree.h>

#include <algorithm>
#include <filesystem>
#include <limits>
#include <map>
#include <memory>
#include <tuple>

#include "OctreeRecord.h"
#include "slalom/core/Rng.h"
#include "slalom/mapping/Mapper.h"

namespace
{
using slalom::core::Occupancy;
using slalom::core::Ray;
using slalom::core::Rng;
using slalom::core::Sphere;
using slalom::mapping::Mapper;
using slalom::mapping::MapperConfig;
using slalom::mapping::MoverMask;
using slalom::mapping::detail::Brick;
using Vec3 = Eigen::Vector3d;

MapperConfig config()
{
  MapperConfig c;
  c.bridge_m = 0.0;
  c.min_range_m = 0.0;
  c.start_ball_m = 0.0;
  c.max_distance_m = 1.0;
  c.update_range_m = 4.0;
  c.window_xy_m = 8.8;
  c.window_z_m = 8.8;
  return c;
}

std::vector<Ray> randomScan(Rng& rng, const Vec3& origin, int rays)
{
  std::vector<Ray> scan;
  for (int i = 0; i < rays; ++i)
    scan.push_back(
        {origin.cast<float>(), (origin + rng.uniform(0.3, 6.0) * rng.direction()).cast<float>()});
  return scan;
}

// Visits the centres of the cells of a window.
template <class Visit>
void eachCell(const Mapper& mapper, Visit&& visit)
{
  const Eigen::AlignedBox3d box = mapper.snapshot()->bounds();
  const double r = mapper.snapshot()->resolution();
  for (double x = box.min().x(); x <= box.max().x() + 1e-6; x += r)
    for (double y = box.min().y(); y <= box.max().y() + 1e-6; y += r)
      for (double z = box.min().z(); z <= box.max().z() + 1e-6; z += r)
        visit(Vec3(Vec3(x, y, z).cwiseMin(box.max())));
}

TEST(MoverMask, MaskedRaysClearLikeOctomapsAndMarkNothing)
{
  for (std::uint64_t seed = 0; seed < 5; ++seed)
  {
    SCOPED_TRACE(seed);
    Rng rng(seed);
    const MapperConfig c = config();
    Mapper mapper(c);
    octomap::OcTree tree(c.resolution_m);
    tree.setProbHit(c.hit);
    tree.setProbMiss(c.miss);
    tree.setClampingThresMin(c.clamp_min);
    tree.setClampingThresMax(c.clamp_max);
    const Vec3 origin = rng.uniform3(-5.0, 5.0);
    for (int k = 0; k < 5; ++k)
    {
      std::vector<Ray> scan;
      std::vector<std::uint8_t> masked;
      for (int i = 0; i < 300; ++i)
      {
        scan.push_back({origin.cast<float>(),
                        (origin + rng.uniform(0.3, 3.6) * rng.direction()).cast<float>()});
        masked.push_back(rng.uniform() < 0.4);
      }
      const auto update = mapper.integrate(0.1 * k, origin, scan, MoverMask{masked, {}});
      EXPECT_EQ(update.rays_on_movers, std::count(masked.begin(), masked.end(), 1));
      EXPECT_EQ(update.rays + update.rays_on_movers, 300);

      octomap::KeySet passed, hit;
      const octomap::point3d from(scan[0].origin_L.x(), scan[0].origin_L.y(), scan[0].origin_L.z());
      for (std::size_t i = 0; i < scan.size(); ++i)
      {
        const auto end = tree.coordToKey(scan[i].end_L.x(), scan[i].end_L.y(), scan[i].end_L.z());
        octomap::KeyRay keys;
        ASSERT_TRUE(tree.computeRayKeys(from, tree.keyToCoord(end), keys));
        passed.insert(keys.begin(), keys.end());
        if (!masked[i]) hit.insert(end);
      }
      for (const auto& key : passed)
        if (hit.count(key) == 0) tree.updateNode(key, false);
      for (const auto& key : hit) tree.updateNode(key, true);
    }
    int different = 0, occupied = 0;
    eachCell(mapper,
             [&](const Vec3& p)
             {
               const auto* node = tree.search(p.x(), p.y(), p.z());
               const Occupancy expected = node == nullptr             ? Occupancy::Unknown
                                          : tree.isNodeOccupied(node) ? Occupancy::Occupied
                                                                      : Occupancy::Free;
               different += mapper.snapshot()->occupancy(p) != expected;
               occupied += expected == Occupancy::Occupied;
             });
    EXPECT_EQ(different, 0);
    EXPECT_GT(occupied, 100);
  }
}

// Ghosts take the occupied cells of their balls out of the window and out of the record, and touch
// nothing else; also after the cells have left the window and come back.
TEST(MoverMask, GhostsBecomeUnknownInTheWindowInTheRecordAndInTheFile)
{
  for (std::uint64_t seed = 0; seed < 6; ++seed)
  {
    SCOPED_TRACE(seed);
    Rng rng(seed);
    MapperConfig c = config();
    c.forget_s = seed % 2 ? 1e3 : 0.0;
    Mapper mapper(c);
    const Vec3 home = rng.uniform3(-3.0, 3.0), away = home + Vec3(40.0, 0.0, 0.0);
    for (int k = 0; k < 4; ++k) mapper.integrate(0.1 * k, home, randomScan(rng, home, 600));
    if (seed % 3 > 0)
    {
      // Now the record knows the cells as well.
      mapper.integrate(1.0, away, {});
      mapper.integrate(1.1, home, {});
    }
    std::map<std::tuple<double, double, double>, Occupancy> expected;
    std::vector<Sphere> ghosts;
    for (int i = 0; i < 6; ++i)
      ghosts.push_back({home + rng.uniform3(-3.0, 3.0), rng.uniform(0.2, 1.2)});
    int cleared = 0, kept = 0;
    eachCell(mapper,
             [&](const Vec3& p)
             {
               Occupancy value = mapper.snapshot()->occupancy(p);
               kept += value == Occupancy::Occupied;
               for (const Sphere& ghost : ghosts)
                 if (value == Occupancy::Occupied && (p - ghost.centre_L).norm() <= ghost.radius_m)
                   value = Occupancy::Unknown, ++cleared, --kept;
               expected[{p.x(), p.y(), p.z()}] = value;
             });
    ASSERT_GT(cleared, 10);
    ASSERT_GT(kept, 100);
    const auto update = mapper.integrate(2.0, home, {}, MoverMask{{}, ghosts});
    EXPECT_EQ(update.cells_changed, cleared);
    for (const bool travelled : {false, true})
    {
      SCOPED_TRACE(travelled);
      if (travelled)
      {
        mapper.integrate(3.0, away, {});
        mapper.integrate(4.0, home, {});
      }
      int different = 0;
      eachCell(mapper,
               [&](const Vec3& p)
               {
                 const auto found = expected.find({p.x(), p.y(), p.z()});
                 different +=
                     found == expected.end() || mapper.snapshot()->occupancy(p) != found->second;
               });
      EXPECT_EQ(different, 0);

      const auto file = std::filesystem::path(testing::TempDir()) /
                        ("ghosts" + std::to_string(seed) + std::to_string(travelled) + ".bt");
      ASSERT_TRUE(mapper.writeOctree(file));
      octomap::OcTree tree(file.string());
      int wrong = 0;
      for (const auto& [at, value] : expected)
      {
        const auto* node = tree.search(std::get<0>(at), std::get<1>(at), std::get<2>(at));
        const Occupancy stored = node == nullptr             ? Occupancy::Unknown
                                 : tree.isNodeOccupied(node) ? Occupancy::Occupied
                                                             : Occupancy::Free;
        wrong += stored != value;
      }
      EXPECT_EQ(wrong, 0);
      std::filesystem::remove(file);
    }
  }
}

// The octree of record against a plain table, for any mixture of writing and erasing.
TEST(MoverMask, RecordErasesExactlyWhatItIsTold)
{
  for (std::uint64_t seed = 0; seed < 20; ++seed)
  {
    SCOPED_TRACE(seed);
    Rng rng(seed);
    slalom::mapping::detail::OctreeRecord record(0.2, 0.5);
    const std::size_t empty = record.bytes();
    std::map<std::tuple<int, int, int>, Brick> table;
    const auto place = [&] { return std::tuple(rng.integer(-3, 3), rng.integer(-3, 3), 0); };
    const auto at = [](const std::tuple<int, int, int>& p)
    { return Eigen::Vector3i(std::get<0>(p), std::get<1>(p), std::get<2>(p)); };
    for (int k = 0; k < 400; ++k)
    {
      const auto p = place();
      if (rng.uniform() < 0.5)
      {
        Brick brick;
        brick.known = rng.uniform() < 0.4 ? ~std::uint64_t{0} : rng.bits();
        const bool uniform = rng.uniform() < 0.5;  // pruned, up to several bricks
        for (float& value : brick.log_odds)
          value = uniform ? -2.0f : static_cast<float>(rng.uniform(-2.0, 3.0));
        record.write(at(p), brick);
        Brick& mine = table[p];
        for (std::size_t i = 0; i < 64; ++i)
          if (brick.known >> i & 1) mine.log_odds[i] = brick.log_odds[i];
        mine.known |= brick.known;
      }
      else
      {
        const std::uint64_t cells =
            rng.uniform() < 0.3 ? ~std::uint64_t{0} : rng.bits() & rng.bits();
        record.erase(at(p), cells);
        table[p].known &= ~cells;
      }
    }
    for (const auto& [p, brick] : table)
    {
      const Brick stored = record.read(at(p));
      ASSERT_EQ(stored.known, brick.known);
      for (std::size_t i = 0; i < 64; ++i)
        ASSERT_TRUE((brick.known >> i & 1) == 0 || stored.log_odds[i] == brick.log_odds[i]);
    }
    EXPECT_GT(record.bytes(), empty);
    for (const auto& [p, brick] : table) record.erase(at(p), ~std::uint64_t{0});
    for (const auto& [p, brick] : table) EXPECT_EQ(record.read(at(p)).known, 0u);
  }
}

TEST(MoverMask, NoMoversChangesNothingAndUselessGhostsAreIgnored)
{
  for (std::uint64_t seed = 0; seed < 3; ++seed)
  {
    SCOPED_TRACE(seed);
    Rng rng(seed);
    Mapper plain(config()), with(config());
    const double nan = std::numeric_limits<double>::quiet_NaN();
    const std::vector<Sphere> useless = {
        {Vec3(nan, 0, 0), 1.0}, {Vec3(1e12, 0, 0), 1.0}, {Vec3::Zero(), nan}, {Vec3::Zero(), -1.0}};
    for (int k = 0; k < 5; ++k)
    {
      const Vec3 p(0.5 * k, 0, 0);
      const std::vector<Ray> scan = randomScan(rng, p, 300);
      const std::vector<std::uint8_t> nobody(scan.size() / 2, 0);  // shorter than the scan
      const auto a = plain.integrate(0.1 * k, p, scan);
      const auto b = with.integrate(0.1 * k, p, scan, MoverMask{nobody, useless});
      EXPECT_EQ(a.rays, b.rays);
      EXPECT_EQ(a.cells_changed, b.cells_changed);
    }
    int different = 0;
    eachCell(plain, [&](const Vec3& p)
             { different += plain.snapshot()->occupancy(p) != with.snapshot()->occupancy(p); });
    EXPECT_EQ(different, 0);
  }
}

}  // namespace
