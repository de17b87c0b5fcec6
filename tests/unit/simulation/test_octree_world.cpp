// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <octomap/octomap.h>

#include <cmath>
#include <sstream>

#include "SharedData.h"
#include "TempFile.h"
#include "slalom/core/Rng.h"
#include "slalom/simulation/World.h"

namespace slalom::simulation
{
namespace
{
using core::Rng;
using Eigen::Vector3d;
using test::messageOf;
using test::TempFile;
using testing::HasSubstr;

constexpr double kResolution = 0.1;

void paint(octomap::OcTree& tree, const Vector3d& p, bool occupied)
{
  tree.updateNode(octomap::point3d(static_cast<float>(p.x()), static_cast<float>(p.y()),
                                   static_cast<float>(p.z())),
                  occupied ? 10.0f : -10.0f);
}

std::string written(octomap::OcTree& tree, bool binary)
{
  std::ostringstream stream;
  binary ? tree.writeBinary(stream) : tree.write(stream);
  return stream.str();
}

/// Random blocks, some large enough to be pruned into coarse leaves, some known to be free.
void randomTree(Rng& rng, octomap::OcTree& tree)
{
  for (int k = 0; k < 25; ++k)
  {
    const Vector3d corner = rng.uniform3(-2.5, 2.5);
    const Vector3d size = rng.uniform3(0.1, 0.9);
    const bool occupied = rng.uniform() < 0.7;
    for (double x = 0.0; x < size.x(); x += kResolution)
      for (double y = 0.0; y < size.y(); y += kResolution)
        for (double z = 0.0; z < size.z(); z += kResolution)
          paint(tree, corner + Vector3d(x, y, z), occupied);
  }
  tree.updateInnerOccupancy();
  tree.prune();
}

/// Marks every voxel of `tree` solid or free, so that nothing is left for shells to enclose.
void knowEverything(octomap::OcTree& tree)
{
  for (double x = -3.55; x < 4.0; x += kResolution)
    for (double y = -3.55; y < 4.0; y += kResolution)
      for (double z = -3.55; z < 4.0; z += kResolution)
        if (!tree.search(x, y, z)) paint(tree, Vector3d(x, y, z), false);
  tree.updateInnerOccupancy();
}

bool occupiedAt(const octomap::OcTree& tree, const Vector3d& p)
{
  const octomap::OcTreeNode* node = tree.search(p.x(), p.y(), p.z());
  return node && tree.isNodeOccupied(node);
}

TEST(OctreeWorld, ReadsBothFormatsAsLiboctomapDoes)
{
  for (std::uint64_t seed = 0; seed < 2; ++seed)
  {
    SCOPED_TRACE(seed);
    Rng rng(seed);
    octomap::OcTree tree(kResolution);
    randomTree(rng, tree);
    knowEverything(tree);
    const TempFile full("w.ot", written(tree, false)), binary("w.bt", written(tree, true));
    const World worlds[] = {World::load(full.path()), World::load(binary.path())};
    for (int k = 0; k < 20000; ++k)
    {
      const Vector3d p = rng.uniform3(-3.5, 3.5);
      for (const World& world : worlds)
        ASSERT_EQ(world.distance(p) < 0.0, occupiedAt(tree, p)) << p.transpose();
    }
  }
}

struct LeafBoxes
{
  std::vector<Box> solid, empty;
  explicit LeafBoxes(const octomap::OcTree& tree)
  {
    for (auto it = tree.begin_leafs(); it != tree.end_leafs(); ++it)
    {
      const Vector3d centre(it.getX(), it.getY(), it.getZ());
      const Vector3d half = Vector3d::Constant(0.5 * it.getSize());
      (tree.isNodeOccupied(*it) ? solid : empty).emplace_back(centre - half, centre + half);
    }
  }
};

TEST(OctreeWorld, DistanceIsThatOfTheNearestVoxelByBruteForce)
{
  for (std::uint64_t seed = 10; seed < 12; ++seed)
  {
    SCOPED_TRACE(seed);
    Rng rng(seed);
    octomap::OcTree tree(kResolution);
    randomTree(rng, tree);
    knowEverything(tree);
    const TempFile file("w.bt", written(tree, true));
    const World world = World::load(file.path());
    const LeafBoxes leaves(tree);
    for (int k = 0; k < 300; ++k)
    {
      const Vector3d p = rng.uniform3(-5.0, 5.0);
      double out = 1e9, in = 1e9;
      for (const Box& b : leaves.solid) out = std::min(out, b.exteriorDistance(p));
      for (const Box& b : leaves.empty) in = std::min(in, b.exteriorDistance(p));
      EXPECT_NEAR(world.distance(p), out > 0.0 ? out : -in, 1e-6) << p.transpose();
    }
  }
}

/// Where the ray enters the box, [m] from the origin.
double entry(const Box& box, const Vector3d& origin, const Vector3d& direction)
{
  double enter = 0.0, leave = 1e9;
  for (int i = 0; i < 3; ++i)
  {
    if (direction[i] == 0.0)
    {
      if (origin[i] < box.min()[i] || origin[i] > box.max()[i]) return 1e9;
      continue;
    }
    const double a = (box.min()[i] - origin[i]) / direction[i];
    const double b = (box.max()[i] - origin[i]) / direction[i];
    enter = std::max(enter, std::min(a, b));
    leave = std::min(leave, std::max(a, b));
  }
  return enter <= leave ? enter : 1e9;
}

TEST(OctreeWorld, RayEndsAtTheFirstVoxelByBruteForce)
{
  for (std::uint64_t seed = 20; seed < 22; ++seed)
  {
    SCOPED_TRACE(seed);
    Rng rng(seed);
    octomap::OcTree tree(kResolution);
    randomTree(rng, tree);
    knowEverything(tree);
    const TempFile file("w.bt", written(tree, true));
    const World world = World::load(file.path());
    const LeafBoxes leaves(tree);
    for (int k = 0; k < 300; ++k)
    {
      const Vector3d origin = rng.uniform3(-5.0, 5.0);
      Vector3d direction = rng.direction();
      if (k % 5 == 0) direction[rng.integer(0, 2)] = 0.0;
      direction.normalize();
      constexpr double kRange = 6.0;
      double first = 1e9;
      for (const Box& box : leaves.solid) first = std::min(first, entry(box, origin, direction));
      const std::optional<double> hit = world.castRay(origin, direction, kRange);
      EXPECT_NEAR(hit.value_or(1e9), first < kRange ? first : 1e9, 1e-5) << "ray " << k;
    }
  }
}

/// A tube of voxels around (x, y), from z = 0 to `top`, open at both ends; every `gap`-th slice has
/// a hole of two voxels.
void drawTube(octomap::OcTree& tree, double x, double y, double radius, double top, int gap)
{
  int slice = 0;
  for (double z = 0.05; z < top; z += kResolution, ++slice)
    for (double a = 0.0; a < 6.2831853; a += 0.02)
    {
      const bool hole = gap > 0 && slice % gap == 0 && radius * a < 0.15;
      if (!hole) paint(tree, {x + radius * std::cos(a), y + radius * std::sin(a), z}, true);
    }
}

TEST(OctreeWorld, HollowTrunkIsSolid)
{
  octomap::OcTree tree(kResolution);
  drawTube(tree, 0.05, 0.05, 0.5, 3.0, 0);
  drawTube(tree, 3.05, 0.05, 0.5, 3.0, 2);  // every second slice leaks
  drawTube(tree, -3.05, 0.05, 0.2, 3.0, 0);
  const TempFile file("w.bt", written(tree, true));
  const World world = World::load(file.path());
  for (const double x : {0.05, 3.05, -3.05})
    for (double z = 0.3; z < 2.7; z += 0.1)
      EXPECT_LT(world.distance({x, 0.05, z}), 0.0) << "trunk at " << x << ", z " << z;
  EXPECT_GT(world.distance({1.55, 0.05, 1.0}), 0.5);
  EXPECT_GT(world.distance({0.05, 0.05, 3.3}), 0.2);
}

TEST(OctreeWorld, AnArenaIsNotATrunk)
{
  octomap::OcTree tree(kResolution);
  drawTube(tree, 0.05, 0.05, 3.0, 2.0, 0);
  const TempFile file("w.bt", written(tree, true));
  EXPECT_GT(World::load(file.path()).distance({0.05, 0.05, 1.0}), 2.5);
}

TEST(OctreeWorld, KnownFreeSpaceStaysFree)
{
  octomap::OcTree tree(kResolution);
  drawTube(tree, 0.05, 0.05, 0.6, 2.0, 0);
  for (double z = 0.05; z < 2.0; z += kResolution) paint(tree, {0.05, 0.05, z}, false);
  const TempFile file("w.bt", written(tree, true));
  EXPECT_GT(World::load(file.path()).distance({0.05, 0.05, 1.0}), 0.3);
}

TEST(OctreeWorld, ClosedBoxIsSolidWhateverItsSize)
{
  octomap::OcTree tree(kResolution);
  for (double u = -2.95; u < 3.0; u += kResolution)
    for (double v = -2.95; v < 3.0; v += kResolution)
      for (const double side : {-2.95, 2.95})
      {
        paint(tree, {u, v, side}, true);
        paint(tree, {u, side, v}, true);
        paint(tree, {side, u, v}, true);
      }
  const TempFile file("w.bt", written(tree, true));
  EXPECT_LT(World::load(file.path()).distance(Vector3d::Zero()), -2.9);
}

TEST(OctreeWorld, DamagedFilesAreRefused)
{
  Rng rng(5);
  octomap::OcTree tree(kResolution);
  randomTree(rng, tree);
  for (const bool binary : {true, false})
  {
    const std::string good = written(tree, binary);
    const char* name = binary ? "w.bt" : "w.ot";
    for (int k = 0; k < 50; ++k)
    {
      const std::size_t length =
          static_cast<std::size_t>(rng.integer(1, static_cast<int>(good.size()) - 1));
      const TempFile file(name, good.substr(0, length));
      EXPECT_THAT(messageOf([&] { (void)World::load(file.path()); }), HasSubstr(name)) << length;
    }
    for (int k = 0; k < 50; ++k)
    {
      std::string bad = good;
      for (int flips = 0; flips < 20; ++flips)
        bad[static_cast<std::size_t>(rng.integer(120, static_cast<int>(bad.size()) - 1))] =
            static_cast<char>(rng.bits());
      const TempFile file(name, bad);
      // Damage may go unnoticed where it only moves voxels; it must never do harm.
      try
      {
        (void)World::load(file.path());
      }
      catch (const std::runtime_error&)
      {
      }
    }
  }
  const TempFile text("w.bt", "hello world\n");
  EXPECT_THAT(messageOf([&] { (void)World::load(text.path()); }), HasSubstr("not an OctoMap"));
}

TEST(OctreeWorld, RealForestKeepsItsVoxelsAndItsPaths)
{
  const auto file = test::sharedData("real/forest_ponderosa_tls/forest_tls_24x29_0.1.bt");
  if (!exists(file)) GTEST_SKIP() << file;
  octomap::OcTree tree(file.string());
  const World world = World::load(file);
  EXPECT_FALSE(world.hasGround());
  Rng rng(1);
  int closed = 0;
  for (auto it = tree.begin_leafs(); it != tree.end_leafs(); ++it)
    if (rng.uniform() < 0.02 && world.distance(Vector3d(it.getX(), it.getY(), it.getZ())) >= 0.0)
      ADD_FAILURE() << "lost voxel at " << it.getCoordinate();
  // Filling may close pockets, not the space that a vehicle uses.
  for (int k = 0; k < 2000; ++k)
  {
    const Vector3d p(rng.uniform(-12.0, 12.0), rng.uniform(-14.0, 14.0), rng.uniform(1.0, 3.0));
    if (world.distance(p) < 0.0 && !occupiedAt(tree, p)) ++closed;
  }
  EXPECT_LT(closed, 20);
}
}  // namespace
}  // namespace slalom::simulation
