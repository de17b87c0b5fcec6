// SPDX-License-Identifier: BSD-3-Clause
// Laws of the mapper; OctoMap itself is the oracle for what a scan does to a map.
#include <gtest/gtest.h>
#include <octomap/OcTree.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "slalom/core/Rng.h"
#include "slalom/mapping/Mapper.h"

namespace
{
using slalom::core::Occupancy;
using slalom::core::Ray;
using slalom::core::Rng;
using slalom::core::UnknownAs;
using slalom::mapping::EdtSnapshot;
using slalom::mapping::Mapper;
using slalom::mapping::MapperConfig;
using slalom::mapping::MapUpdate;
using Vec3 = Eigen::Vector3d;

MapperConfig config(double resolution = 0.2)
{
  MapperConfig c;
  c.bridge_m = 0.0;  // has a law of its own
  c.resolution_m = resolution;
  c.min_range_m = 0.0;
  c.start_ball_m = 0.0;
  c.max_distance_m = 1.0;
  c.update_range_m = 4.0;
  c.window_xy_m = 8.8;
  c.window_z_m = 8.8;
  return c;
}

octomap::OcTree oracle(const MapperConfig& c)
{
  octomap::OcTree tree(c.resolution_m);
  tree.setProbHit(c.hit);
  tree.setProbMiss(c.miss);
  tree.setClampingThresMin(c.clamp_min);
  tree.setClampingThresMax(c.clamp_max);
  tree.setOccupancyThres(c.occupied_threshold);
  return tree;
}

octomap::point3d octo(const Eigen::Vector3f& p)
{
  return {p.x(), p.y(), p.z()};
}

Occupancy classOf(const octomap::OcTree& tree, const Vec3& p)
{
  const octomap::OcTreeNode* node = tree.search(p.x(), p.y(), p.z());
  if (node == nullptr) return Occupancy::Unknown;
  return tree.isNodeOccupied(node) ? Occupancy::Occupied : Occupancy::Free;
}

std::vector<Ray> randomScan(Rng& rng, const Vec3& origin, int rays, double min, double max)
{
  std::vector<Ray> scan;
  for (int i = 0; i < rays; ++i)
  {
    Ray ray;
    ray.origin_L = origin.cast<float>();
    ray.end_L = (origin + rng.uniform(min, max) * rng.direction()).cast<float>();
    scan.push_back(ray);
  }
  return scan;
}

// Visits the centres of all cells inside the bounds of a snapshot.
template <class Visit>
void eachCell(const EdtSnapshot& snapshot, Visit&& visit)
{
  const double r = snapshot.resolution();
  const Eigen::Vector3i n =
      (snapshot.bounds().sizes() / r).array().round().cast<int>() + Eigen::Array3i::Ones();
  // Inwards by a hair, because rounding may put outermost centres outside.
  const Eigen::AlignedBox3d box = snapshot.bounds();
  for (int z = 0; z < n.z(); ++z)
    for (int y = 0; y < n.y(); ++y)
      for (int x = 0; x < n.x(); ++x)
        visit(Vec3((box.min() + r * Vec3(x, y, z)).cwiseMin(box.max())));
}

std::size_t count(const EdtSnapshot& snapshot, Occupancy value)
{
  std::size_t n = 0;
  eachCell(snapshot, [&](const Vec3& p) { n += snapshot.occupancy(p) == value; });
  return n;
}

bool same(const EdtSnapshot& a, const EdtSnapshot& b)
{
  bool equal = a.bounds().isApprox(b.bounds());
  eachCell(a,
           [&](const Vec3& p)
           {
             equal = equal && a.occupancy(p) == b.occupancy(p);
             for (const UnknownAs unknown : {UnknownAs::Free, UnknownAs::Occupied})
             {
               const auto one = a.sample(p, unknown), other = b.sample(p, unknown);
               equal = equal && one && other && one->distance == other->distance &&
                       one->gradient == other->gradient;
             }
           });
  return equal;
}

std::filesystem::path temporary(const std::string& name)
{
  const auto* info = testing::UnitTest::GetInstance()->current_test_info();
  return std::filesystem::path(testing::TempDir()) / (std::string(info->name()) + "_" + name);
}

TEST(Mapper, CellsEqualOctomapsDiscretizedInsertion)
{
  for (std::uint64_t seed = 0; seed < 6; ++seed)
  {
    SCOPED_TRACE(seed);
    Rng rng(seed);
    const MapperConfig c = config(seed % 2 ? 0.2 : 0.13);
    Mapper mapper(c);
    octomap::OcTree tree = oracle(c);
    const Vec3 base = rng.uniform3(-50.0, 50.0);
    for (int k = 0; k < 6; ++k)
    {
      const Vec3 origin = base + rng.uniform3(-0.3, 0.3);
      const std::vector<Ray> scan = randomScan(rng, origin, 400, 0.0, 3.9);
      octomap::Pointcloud cloud;
      for (const Ray& ray : scan) cloud.push_back(octo(ray.end_L));
      tree.insertPointCloud(cloud, octo(scan[0].origin_L), c.update_range_m, false, true);
      const MapUpdate update = mapper.integrate(0.1 * k, origin, scan);
      EXPECT_EQ(update.rays, 400);
      EXPECT_EQ(update.rays_out_of_range, 0);
    }
    int seen = 0, different = 0;
    eachCell(*mapper.snapshot(),
             [&](const Vec3& p)
             {
               different += mapper.snapshot()->occupancy(p) != classOf(tree, p);
               seen += classOf(tree, p) != Occupancy::Unknown;
             });
    EXPECT_EQ(different, 0);
    EXPECT_GT(seen, 2000);
  }
}

TEST(Mapper, RaysBeyondRangeClearUpToItAndMakeNoObstacle)
{
  for (std::uint64_t seed = 0; seed < 4; ++seed)
  {
    SCOPED_TRACE(seed);
    Rng rng(seed);
    const MapperConfig c = config();
    Mapper mapper(c);
    const Vec3 origin = rng.uniform3(-1.0, 1.0);
    const std::vector<Ray> scan = randomScan(rng, origin, 300, 4.3, 60.0);
    const MapUpdate update = mapper.integrate(0.0, origin, scan);
    EXPECT_EQ(update.rays, 0);
    EXPECT_EQ(update.rays_out_of_range, 300);

    // The reference casts each ray on its own, to the voxel that holds its point at the range.
    octomap::OcTree tree = oracle(c);
    for (const Ray& ray : scan)
    {
      const Eigen::Vector3f along = ray.end_L - ray.origin_L;
      const float scale = static_cast<float>(c.update_range_m / along.cast<double>().norm());
      const octomap::OcTreeKey end = tree.coordToKey(octo(ray.origin_L + scale * along));
      octomap::KeyRay keys;
      ASSERT_TRUE(tree.computeRayKeys(octo(ray.origin_L), tree.keyToCoord(end), keys));
      for (const octomap::OcTreeKey& key : keys) tree.updateNode(key, false);
    }
    int different = 0;
    const double reach = c.update_range_m + c.resolution_m * std::sqrt(3.0);
    eachCell(*mapper.snapshot(),
             [&](const Vec3& p)
             {
               const Occupancy value = mapper.snapshot()->occupancy(p);
               different += value != classOf(tree, p);
               EXPECT_NE(value, Occupancy::Occupied);
               if (value == Occupancy::Free)
               {
                 EXPECT_LE((p - origin).norm(), reach);
               }
             });
    EXPECT_EQ(different, 0);
  }
}

TEST(Mapper, NearAndNonFiniteRaysAreIgnored)
{
  MapperConfig c = config();
  c.min_range_m = 0.5;
  Mapper mapper(c);
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float inf = std::numeric_limits<float>::infinity();
  std::vector<Ray> scan;
  for (const float bad : {nan, inf, -inf, 1e30f})
    for (int axis = 0; axis < 6; ++axis)
    {
      Ray ray{{0, 0, 0}, {2, 0, 0}};
      (axis < 3 ? ray.origin_L : ray.end_L)[axis % 3] = bad;
      scan.push_back(ray);
    }
  scan.push_back({{0, 0, 0}, {0.45f, 0, 0}});
  scan.push_back({{0, 0, 0}, {0, 0, 0}});
  const MapUpdate update = mapper.integrate(1.0, Vec3::Zero(), scan);
  EXPECT_EQ(update.rays + update.rays_out_of_range, 0);
  EXPECT_EQ(update.cells_changed, 0);
  ASSERT_NE(mapper.snapshot(), nullptr);
  EXPECT_EQ(count(*mapper.snapshot(), Occupancy::Free), 0u);
  EXPECT_EQ(count(*mapper.snapshot(), Occupancy::Occupied), 0u);
  // A pose that is no number cannot place a window.
  EXPECT_EQ(mapper.integrate(2.0, Vec3(nan, 0, 0), scan).cells_changed, 0);
  EXPECT_TRUE(mapper.snapshot()->bounds().contains(Vec3::Zero()));
}

TEST(Mapper, EmptyScanChangesNothingButTheSnapshotFollows)
{
  Rng rng(3);
  Mapper mapper(config());
  (void)mapper.integrate(1.0, Vec3::Zero(), randomScan(rng, Vec3::Zero(), 500, 1.0, 3.9));
  const auto before = mapper.snapshot();
  EXPECT_EQ(before->stamp(), 1.0);
  EXPECT_EQ(mapper.integrate(2.0, Vec3::Zero(), {}).cells_changed, 0);
  const auto after = mapper.snapshot();
  EXPECT_TRUE(same(*before, *after));
  EXPECT_EQ(after->stamp(), 1.0);  // of the newest data
  EXPECT_GT(after->sequence(), before->sequence());

  const Vec3 there(3.1, -2.3, 0.7);
  (void)mapper.integrate(3.0, there, {});
  const auto moved = mapper.snapshot();
  EXPECT_LT((moved->bounds().center() - there).cwiseAbs().maxCoeff(), 0.8 + 1e-9);
  eachCell(*moved,
           [&](const Vec3& p)
           {
             if (before->bounds().contains(p))
             {
               EXPECT_EQ(moved->occupancy(p), before->occupancy(p));
             }
             else
             {
               EXPECT_EQ(moved->occupancy(p), Occupancy::Unknown);
             }
           });
}

TEST(Mapper, DistancesAreThoseOfItsOccupancy)
{
  Rng rng(9);
  const MapperConfig c = config();
  Mapper mapper(c);
  Vec3 p = rng.uniform3(-1.0, 1.0);
  for (int k = 0; k < 5; ++k)
  {
    (void)mapper.integrate(k, p, randomScan(rng, p, 300, 1.0, 6.0));
    p += Vec3(0.9, -0.7, 0.3);  // so that the window wraps around in its memory
    const auto snapshot = mapper.snapshot();
    std::vector<Occupancy> cells;
    eachCell(*snapshot, [&](const Vec3& q) { cells.push_back(snapshot->occupancy(q)); });
    const Eigen::Vector3i n =
        (snapshot->bounds().sizes() / c.resolution_m).array().round().cast<int>() + 1;
    const Vec3 corner = snapshot->bounds().min() - Vec3::Constant(0.5 * c.resolution_m);
    const auto expected =
        EdtSnapshot::fromOccupancy(corner, n, c.resolution_m, cells, c.max_distance_m);
    for (int i = 0; i < 3000; ++i)
    {
      Vec3 q;
      for (int axis = 0; axis < 3; ++axis)
        q[axis] = rng.uniform(snapshot->bounds().min()[axis], snapshot->bounds().max()[axis]);
      for (const UnknownAs unknown : {UnknownAs::Free, UnknownAs::Occupied})
        EXPECT_NEAR(snapshot->sample(q, unknown)->distance, expected->sample(q, unknown)->distance,
                    1e-9);
    }
  }
}

TEST(Mapper, ARevisitedPlaceIsRemembered)
{
  Rng rng(4);
  MapperConfig c = config();
  const Vec3 home(0.3, -0.2, 0.1);
  const std::vector<Ray> scan = randomScan(rng, home, 3000, 1.0, 3.9);
  for (const bool keep : {true, false})
  {
    c.keep_octree = keep;
    Mapper mapper(c);
    for (int k = 0; k < 3; ++k) (void)mapper.integrate(k, home, scan);
    const auto before = mapper.snapshot();
    // Out in steps and back at once, so that bricks leave and enter in many ways.
    for (int k = 0; k <= 40; ++k)
      (void)mapper.integrate(3.0 + k, home + k * Vec3(0.7, -0.5, 0.31), {});
    EXPECT_EQ(count(*mapper.snapshot(), Occupancy::Unknown), 44u * 44u * 44u);
    (void)mapper.integrate(50.0, home, {});
    if (keep)
    {
      EXPECT_TRUE(same(*before, *mapper.snapshot()));
    }
    else
    {
      EXPECT_EQ(count(*mapper.snapshot(), Occupancy::Unknown), 44u * 44u * 44u);
    }
  }
}

TEST(Mapper, LogOddsSurviveTheOctreeExactly)
{
  // A far trip between two scans must leave no trace in what later scans make of the map.
  const MapperConfig c = config();
  Mapper stays(c), travels(c);
  Rng rng(8);
  for (int k = 0; k < 8; ++k)
  {
    const Vec3 p = rng.uniform3(-0.5, 0.5);
    const std::vector<Ray> scan = randomScan(rng, p, 300, 1.0, 5.0);
    (void)stays.integrate(k, Vec3::Zero(), scan);
    (void)travels.integrate(k, Vec3::Zero(), scan);
    (void)travels.integrate(k + 0.5, Vec3(100.0 * k, -30.0, 20.0), {});
    (void)travels.integrate(k + 0.6, Vec3::Zero(), {});
    ASSERT_TRUE(same(*stays.snapshot(), *travels.snapshot())) << k;
  }
}

TEST(Mapper, CellsUnseenForLongAreForgotten)
{
  Rng rng(6);
  MapperConfig c = config();
  c.forget_s = 2.0;
  Mapper mapper(c);
  const std::vector<Ray> east = {{{0, 0, 0}, {3.5f, 0.05f, 0.05f}}};
  const std::vector<Ray> north = {{{0, 0, 0}, {0.05f, 3.5f, 0.05f}}};
  const Vec3 in_east(2.1, 0.1, 0.1), in_north(0.1, 2.1, 0.1);
  (void)mapper.integrate(0.0, Vec3::Zero(), east);
  (void)mapper.integrate(1.5, Vec3::Zero(), north);
  EXPECT_EQ(mapper.snapshot()->occupancy(in_east), Occupancy::Free);
  EXPECT_GT(mapper.integrate(2.01, Vec3::Zero(), {}).cells_changed, 5);
  EXPECT_EQ(mapper.snapshot()->occupancy(in_east), Occupancy::Unknown);
  EXPECT_EQ(mapper.snapshot()->occupancy(Vec3(3.5, 0.1, 0.1)), Occupancy::Unknown);
  EXPECT_EQ(mapper.snapshot()->occupancy(in_north), Occupancy::Free);
  // Away and back within the time: remembered, with the time at which it was seen.
  (void)mapper.integrate(2.5, Vec3(50.0, 0.0, 0.0), {});
  (void)mapper.integrate(3.4, Vec3::Zero(), {});
  EXPECT_EQ(mapper.snapshot()->occupancy(in_north), Occupancy::Free);
  EXPECT_EQ(mapper.snapshot()->occupancy(in_east), Occupancy::Unknown);
  (void)mapper.integrate(3.51, Vec3::Zero(), {});
  EXPECT_EQ(mapper.snapshot()->occupancy(in_north), Occupancy::Unknown);
  // Away for longer: forgotten on return.
  (void)mapper.integrate(4.0, Vec3::Zero(), east);
  (void)mapper.integrate(4.1, Vec3(50.0, 0.0, 0.0), {});
  (void)mapper.integrate(9.0, Vec3::Zero(), {});
  EXPECT_EQ(mapper.snapshot()->occupancy(in_east), Occupancy::Unknown);
  EXPECT_EQ(count(*mapper.snapshot(), Occupancy::Unknown), 44u * 44u * 44u);
}

/// Bridged are exactly the unknown cells with a seen-free one near enough above or below and
/// nothing occupied in between.
TEST(Mapper, BridgesUnknownSpaceAboveAndBelowWhatIsFree)
{
  for (const int reach : {1, 2})
  {
    SCOPED_TRACE(reach);
    MapperConfig plain = config(), bridged = config();
    plain.start_ball_m = bridged.start_ball_m = 0.0;
    bridged.bridge_m = reach * plain.resolution_m;
    Mapper without(plain), with(bridged);
    Rng rng(7);
    const Vec3 p(0.1, 0.1, 1.1);
    std::vector<Ray> scan;
    for (int i = 0; i < 60; ++i)
    {
      Vec3 end = p + rng.uniform3(-5.0, 5.0);
      end.z() = p.z() + rng.uniform(-1.0, 1.0);
      scan.push_back({p.cast<float>(), end.cast<float>()});
    }
    (void)without.integrate(0.0, p, scan);
    (void)with.integrate(0.0, p, scan);
    int changed = 0, wrong = 0;
    eachCell(*without.snapshot(),
             [&](const Vec3& q)
             {
               const Occupancy was = without.snapshot()->occupancy(q);
               bool near_free = false;
               for (const int step : {-1, 1})
                 for (int k = 1; k <= reach; ++k)
                 {
                   const Occupancy there =
                       without.snapshot()->occupancy(q + Vec3(0, 0, step * k * plain.resolution_m));
                   near_free |= there == Occupancy::Free;
                   if (there == Occupancy::Occupied) break;  // under a floor nothing was seen
                 }
               const Occupancy expected =
                   was == Occupancy::Unknown && near_free ? Occupancy::Free : was;
               wrong += with.snapshot()->occupancy(q) != expected;
               changed += expected != was;
             });
    EXPECT_EQ(wrong, 0);
    EXPECT_GT(changed, 500);
  }
}

TEST(Mapper, StartBallFreesOnlyUnknownCellsOfTheFirstPose)
{
  MapperConfig c = config();
  c.start_ball_m = 0.9;
  Mapper mapper(c);
  const Vec3 p(0.31, -0.17, 1.05);
  const Vec3 wall = p + Vec3(0.6, 0.0, 0.0);
  const std::vector<Ray> scan = {{p.cast<float>(), wall.cast<float>()}};
  (void)mapper.integrate(0.0, p, scan);
  (void)mapper.integrate(0.1, p + Vec3(2.5, 0.0, 0.0), {});
  int inside = 0;
  eachCell(*mapper.snapshot(),
           [&](const Vec3& q)
           {
             const Occupancy value = mapper.snapshot()->occupancy(q);
             if ((q - wall).cwiseAbs().maxCoeff() < 0.1)
             {
               EXPECT_EQ(value, Occupancy::Occupied);
             }
             else if ((q - p).norm() < 0.9 - 1e-9)
             {
               ++inside;
               EXPECT_EQ(value, Occupancy::Free);
             }
             else if ((q - p).norm() > 0.9 + 1e-9)
             {
               EXPECT_EQ(value, Occupancy::Unknown);
             }
           });
  EXPECT_GT(inside, 300);
}

TEST(Mapper, OctreeMemoryStaysBoundedAndKeepsWhatIsNear)
{
  MapperConfig c = config(0.1);
  c.update_range_m = 2.0;
  c.window_xy_m = 4.8;
  c.window_z_m = 4.8;
  c.max_octree_mb = 1.0;
  Mapper mapper(c);
  Mapper empty(c);
  const std::size_t window = empty.memoryBytes();
  Rng rng(12);
  std::size_t largest = 0;
  Vec3 p = Vec3::Zero();
  std::shared_ptr<const EdtSnapshot> before;
  for (int k = 0; k < 120; ++k)
  {
    if (k == 113) before = mapper.snapshot();
    p = Vec3(0.8 * k, 0.0, 0.0);
    (void)mapper.integrate(0.1 * k, p, randomScan(rng, p, 60, 0.5, 2.5));
    largest = std::max(largest, mapper.memoryBytes() - window);
    ASSERT_LE(mapper.memoryBytes() - window, 1000000u);
  }
  EXPECT_GT(largest, 700000u);  // the bound was reached, and dropping does not empty the map
  // The place left 5 m ago, out of the window by now, is still known; the start is not.
  (void)mapper.integrate(20.0, Vec3(0.8 * 112, 0.0, 0.0), {});
  EXPECT_GT(count(*mapper.snapshot(), Occupancy::Free), count(*before, Occupancy::Free) / 2);
  (void)mapper.integrate(21.0, Vec3::Zero(), {});
  EXPECT_EQ(count(*mapper.snapshot(), Occupancy::Free), 0u);
}

TEST(Mapper, TwoRunsAreIdenticalAndOldSnapshotsStayAsTheyWere)
{
  Mapper a(config()), b(config());
  Rng rng(77);
  std::shared_ptr<const EdtSnapshot> old;
  std::vector<double> old_distances;
  const auto distances = [](const EdtSnapshot& snapshot)
  {
    std::vector<double> all;
    eachCell(snapshot, [&](const Vec3& p)
             { all.push_back(snapshot.sample(p, UnknownAs::Occupied)->distance); });
    return all;
  };
  for (int k = 0; k < 10; ++k)
  {
    const Vec3 p = Vec3(0.4 * k, 0.2 * k, 0.1 * k) + rng.uniform3(-0.1, 0.1);
    const std::vector<Ray> scan = randomScan(rng, p, 800, 0.5, 6.0);
    const MapUpdate one = a.integrate(k, p, scan), other = b.integrate(k, p, scan);
    EXPECT_EQ(one.cells_changed, other.cells_changed);
    ASSERT_TRUE(same(*a.snapshot(), *b.snapshot()));
    if (k == 2) old = a.snapshot(), old_distances = distances(*old);
  }
  EXPECT_EQ(distances(*old), old_distances);
  const auto fileOf = [](Mapper& mapper, const std::string& name)
  {
    const std::filesystem::path file = temporary(name);
    EXPECT_TRUE(mapper.writeOctree(file));
    std::ifstream stream(file, std::ios::binary);
    return std::string(std::istreambuf_iterator<char>(stream), {});
  };
  EXPECT_EQ(fileOf(a, "a.bt"), fileOf(b, "b.bt"));
}

TEST(Mapper, OctomapReadsTheWrittenTree)
{
  const MapperConfig c = config();
  Mapper mapper(c);
  octomap::OcTree tree = oracle(c);
  Rng rng(21);
  // Far enough that most of the map has left the window.
  for (int k = 0; k < 12; ++k)
  {
    const Vec3 p = Vec3(1.3 * k, -0.4 * k, 0.2 * k);
    const std::vector<Ray> scan = randomScan(rng, p, 500, 0.5, 3.6);
    octomap::Pointcloud cloud;
    for (const Ray& ray : scan) cloud.push_back(octo(ray.end_L));
    tree.insertPointCloud(cloud, octo(scan[0].origin_L), c.update_range_m, false, true);
    (void)mapper.integrate(0.1 * k, p, scan);
  }
  const std::filesystem::path file = temporary("map.bt");
  ASSERT_TRUE(mapper.writeOctree(file));
  octomap::OcTree read(file.string());
  EXPECT_EQ(read.getResolution(), c.resolution_m);
  tree.expand();
  int leaves = 0, different = 0;
  for (auto leaf = tree.begin_leafs(); leaf != tree.end_leafs(); ++leaf, ++leaves)
    different += classOf(read, Vec3(leaf.getX(), leaf.getY(), leaf.getZ())) !=
                 (tree.isNodeOccupied(*leaf) ? Occupancy::Occupied : Occupancy::Free);
  EXPECT_EQ(different, 0);
  EXPECT_GT(leaves, 20000);
  read.expand();
  EXPECT_EQ(read.getNumLeafNodes(), tree.getNumLeafNodes());
  std::filesystem::remove(file);
}

TEST(Mapper, TheOctreeKeepsWhatTheWindowForgot)
{
  MapperConfig c = config();
  c.forget_s = 1.0;
  c.start_ball_m = 1.5;  // whole bricks of equal cells, which the octree prunes
  Mapper mapper(c);
  (void)mapper.integrate(0.0, Vec3::Zero(), {});
  EXPECT_GT(mapper.integrate(2.0, Vec3::Zero(), {}).cells_changed, 1000);
  EXPECT_EQ(count(*mapper.snapshot(), Occupancy::Free), 0u);
  // One obstacle inside the ball, then away, so that a part of a brick is written over the whole.
  const std::vector<Ray> scan = {{{0.1f, 0.1f, 0.1f}, {0.9f, 0.1f, 0.1f}}};
  (void)mapper.integrate(3.0, Vec3::Zero(), scan);
  (void)mapper.integrate(3.1, Vec3(40.0, 0.0, 0.0), {});

  const std::filesystem::path file = temporary("map.bt");
  ASSERT_TRUE(mapper.writeOctree(file));
  octomap::OcTree read(file.string());
  int inside = 0;
  for (double x = -1.5; x < 1.5; x += 0.2)
    for (double y = -1.5; y < 1.5; y += 0.2)
      for (double z = -1.5; z < 1.5; z += 0.2)
        if (const Vec3 p(x, y, z); p.norm() < 1.49)
        {
          ++inside;
          const bool obstacle = (p - Vec3(0.9, 0.1, 0.1)).cwiseAbs().maxCoeff() < 0.05;
          EXPECT_EQ(classOf(read, p), obstacle ? Occupancy::Occupied : Occupancy::Free)
              << p.transpose();
        }
  EXPECT_GT(inside, 1000);
  std::filesystem::remove(file);
}

TEST(Mapper, WriteOctreeSaysWhenItCannot)
{
  MapperConfig c = config();
  Mapper mapper(c);
  EXPECT_FALSE(mapper.writeOctree("/nonexistent-directory/map.bt"));
  EXPECT_FALSE(std::filesystem::exists("/nonexistent-directory"));
  c.keep_octree = false;
  EXPECT_FALSE(Mapper(c).writeOctree(temporary("map.bt")));
  EXPECT_FALSE(std::filesystem::exists(temporary("map.bt")));
  // An empty map is a map too.
  const std::filesystem::path file = temporary("empty.bt");
  ASSERT_TRUE(mapper.writeOctree(file));
  EXPECT_EQ(octomap::OcTree(file.string()).size(), 0u);
  std::filesystem::remove(file);
}

TEST(Mapper, ResetForgetsEverything)
{
  Rng rng(2);
  Mapper mapper(config());
  (void)mapper.integrate(0.0, Vec3::Zero(), randomScan(rng, Vec3::Zero(), 300, 1.0, 3.0));
  const std::uint64_t sequence = mapper.snapshot()->sequence();
  mapper.reset();
  EXPECT_EQ(mapper.snapshot(), nullptr);
  (void)mapper.integrate(1.0, Vec3::Zero(), {});
  EXPECT_EQ(count(*mapper.snapshot(), Occupancy::Unknown), 44u * 44u * 44u);
  EXPECT_GT(mapper.snapshot()->sequence(), sequence);
}

TEST(Mapper, RefusesConfigsThatCannotWork)
{
  const auto refused = [](auto&& change)
  {
    MapperConfig c;
    change(c);
    EXPECT_THROW(Mapper{c}, std::invalid_argument);
  };
  EXPECT_NO_THROW(Mapper{MapperConfig{}});
  refused([](MapperConfig& c) { c.resolution_m = 0.0; });
  refused([](MapperConfig& c) { c.resolution_m = std::nan(""); });
  refused([](MapperConfig& c) { c.window_xy_m = 11.9; });
  refused([](MapperConfig& c) { c.window_xy_m = 1e5; });
  refused([](MapperConfig& c) { c.max_distance_m = 15.0, c.resolution_m = 0.05; });
  refused([](MapperConfig& c) { c.min_range_m = 7.0; });
  refused([](MapperConfig& c) { c.occupied_threshold = 0.99; });
  refused([](MapperConfig& c) { c.clamp_max = 1.0; });
}

}  // namespace
