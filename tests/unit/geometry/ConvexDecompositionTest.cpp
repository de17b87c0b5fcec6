// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "slalom/core/Rng.h"
#include "slalom/geometry/ConvexDecomposition.h"

namespace slalom::geometry
{
namespace
{
using core::Rng;
using Cloud = std::vector<Eigen::Vector3d>;

double distanceToSegment(const Eigen::Vector3d& p, const Eigen::Vector3d& a,
                         const Eigen::Vector3d& b)
{
  const Eigen::Vector3d ab = b - a;
  const double s = std::clamp((p - a).dot(ab) / std::max(ab.squaredNorm(), 1e-300), 0.0, 1.0);
  return (p - a - s * ab).norm();
}

struct Problem
{
  Eigen::Vector3d a, b;
  Cloud obstacles;
  DecompositionConfig config;
  double nearest;  ///< distance from the segment to the obstacles
};

/// Segments of any length and direction in clouds of any density; a part has its cloud cleared
/// around the segment.
Problem randomProblem(std::uint64_t seed)
{
  Rng rng(seed);
  Problem p;
  p.a = rng.uniform3(-50.0, 50.0);
  p.b = p.a + rng.direction() * std::exp(rng.uniform(std::log(0.01), std::log(4.0)));
  if (rng.integer(0, 9) == 0) p.b = p.a;
  if (rng.integer(0, 9) == 0) p.b = p.a + Eigen::Vector3d(0, 0, rng.uniform(-2.0, 2.0));
  p.config.along_m = rng.uniform(0.3, 2.0);
  p.config.lateral_m = rng.uniform(0.3, 3.0);
  p.config.vertical_m = rng.uniform(0.3, 3.0);
  p.config.shrink_m = rng.integer(0, 1) == 0 ? 0.0 : rng.uniform(0.0, 0.6);
  const double cleared = rng.integer(0, 2) == 0 ? 0.0 : rng.uniform(0.0, 0.8);
  const bool voxels = rng.integer(0, 1) == 0;
  const int count = rng.integer(0, 400);
  p.nearest = std::numeric_limits<double>::infinity();
  for (int i = 0; i < count; ++i)
  {
    Eigen::Vector3d o = 0.5 * (p.a + p.b) + rng.uniform3(-5.0, 5.0);
    if (rng.integer(0, 99) == 0) o = p.a + rng.uniform() * (p.b - p.a) + rng.uniform3(-0.4, 0.4);
    if (voxels) o = (o / 0.2).array().floor() * 0.2 + 0.1;
    const double away = distanceToSegment(o, p.a, p.b);
    if (away < cleared) continue;
    p.nearest = std::min(p.nearest, away);
    p.obstacles.push_back(o);
  }
  return p;
}

constexpr std::uint64_t kProblems = 4000;

TEST(ConvexDecomposition, ContainsItsSeedExactlyWhenTheObstaclesLeaveRoomForIt)
{
  int held = 0, cut = 0;
  for (std::uint64_t seed = 0; seed < kProblems; ++seed)
  {
    SCOPED_TRACE(seed);
    const Problem p = randomProblem(seed);
    const FreePolyhedron free = decompose(p.a, p.b, p.obstacles, p.config);
    const bool inside = free.set.contains(p.a, 2e-9) && free.set.contains(p.b, 2e-9);
    ASSERT_EQ(free.contains_seed, inside);
    if (p.nearest > std::max(p.config.shrink_m, 1e-5) + 1e-8)
    {
      ASSERT_TRUE(free.contains_seed);
    }
    if (p.nearest < p.config.shrink_m - 1e-8)
    {
      ASSERT_FALSE(free.contains_seed);
    }
    ++(inside ? held : cut);
  }
  EXPECT_GT(held, 1000);
  EXPECT_GT(cut, 300);
}

TEST(ConvexDecomposition, KeepsTheShrinkFromEveryObstacle)
{
  for (std::uint64_t seed = 0; seed < kProblems; ++seed)
  {
    SCOPED_TRACE(seed);
    const Problem p = randomProblem(seed);
    const FreePolyhedron free = decompose(p.a, p.b, p.obstacles, p.config);
    for (const Eigen::Vector3d& o : p.obstacles)
    {
      ASSERT_GE(free.set.violation(o), -1e-9);
      const auto nearest = project(o, free.set);
      if (!nearest) break;  // the shrunk set is empty
      ASSERT_GE((*nearest - o).norm(), p.config.shrink_m - 1e-8);
    }
  }
}

TEST(ConvexDecomposition, HasUnitNormalsAndStaysInItsLocalBox)
{
  for (std::uint64_t seed = 0; seed < kProblems; ++seed)
  {
    SCOPED_TRACE(seed);
    const Problem p = randomProblem(seed);
    const FreePolyhedron free = decompose(p.a, p.b, p.obstacles, p.config);
    ASSERT_EQ(free.set.A.rows(), free.set.b.size());
    ASSERT_TRUE(free.set.A.allFinite() && free.set.b.allFinite());
    for (Eigen::Index i = 0; i < free.set.rows(); ++i)
      ASSERT_NEAR(free.set.A.row(i).norm(), 1.0, 1e-12);
    const Eigen::AlignedBox3d box = localBox(p.a, p.b, p.config);
    Rng rng(seed);
    for (int k = 0; k < 10; ++k)
    {
      const auto q = project(p.a + 1e4 * rng.direction(), free.set);
      if (!q) break;
      ASSERT_LT(box.exteriorDistance(*q), 1e-5);
    }
  }
}

// Every cut has a reason: its plane is `shrink` from some obstacle.
TEST(ConvexDecomposition, EveryCutTouchesAnObstacle)
{
  for (std::uint64_t seed = 0; seed < kProblems; ++seed)
  {
    SCOPED_TRACE(seed);
    const Problem p = randomProblem(seed);
    const FreePolyhedron free = decompose(p.a, p.b, p.obstacles, p.config);
    ASSERT_GE(free.set.rows(), 6);
    for (Eigen::Index i = 0; i < free.set.rows() - 6; ++i)
    {
      double least = std::numeric_limits<double>::infinity();
      for (const Eigen::Vector3d& o : p.obstacles)
        least =
            std::min(least, std::abs(free.set.A.row(i).dot(o) - free.set.b[i] - p.config.shrink_m));
      ASSERT_LT(least, 1e-8);
    }
  }
}

// The box is laid out along the segment: turning the world about the vertical turns the result.
TEST(ConvexDecomposition, TurnsAndMovesWithTheWorld)
{
  for (std::uint64_t seed = 0; seed < 500; ++seed)
  {
    SCOPED_TRACE(seed);
    Problem p = randomProblem(seed);
    // A vertical segment has no side of its own and takes the x axis of the world.
    if ((p.b - p.a).head<2>().norm() <= 0.05 * (p.b - p.a).norm()) continue;
    p.obstacles.resize(std::min<std::size_t>(p.obstacles.size(), 60));
    Rng rng(seed);
    Eigen::Isometry3d move = Eigen::Isometry3d::Identity();
    move.rotate(Eigen::AngleAxisd(rng.uniform(-3.0, 3.0), Eigen::Vector3d::UnitZ()));
    move.pretranslate(rng.uniform3(-10.0, 10.0));
    Cloud moved;
    for (const Eigen::Vector3d& o : p.obstacles) moved.push_back(move * o);
    const FreePolyhedron here = decompose(p.a, p.b, p.obstacles, p.config);
    const FreePolyhedron there = decompose(move * p.a, move * p.b, moved, p.config);
    ASSERT_EQ(here.contains_seed, there.contains_seed);
    for (int k = 0; k < 50; ++k)
    {
      const Eigen::Vector3d x = p.a + rng.uniform3(-2.0, 2.0);
      ASSERT_NEAR(here.set.violation(x), there.set.violation(move * x), 1e-5);
    }
  }
}

TEST(ConvexDecomposition, OpenSpaceIsTheWholeBox)
{
  const DecompositionConfig config{1.0, 2.0, 1.5, 0.4};
  const Eigen::Vector3d a(1, 2, 3), b(4, 2, 3);
  const FreePolyhedron free = decompose(a, b, {}, config);
  EXPECT_EQ(free.set.rows(), 6);
  EXPECT_TRUE(free.contains_seed);
  for (const double x : {0.0, 5.0})
    for (const double y : {0.0, 4.0})
      for (const double z : {1.5, 4.5}) EXPECT_NEAR(free.set.violation({x, y, z}), 0.0, 1e-12);
  const Eigen::AlignedBox3d box = localBox(a, b, config);  // grown by the shrink
  EXPECT_LT((box.min() - Eigen::Vector3d(-0.4, -0.4, 1.1)).norm(), 1e-12);
  EXPECT_LT((box.max() - Eigen::Vector3d(5.4, 4.4, 4.9)).norm(), 1e-12);
}

TEST(ConvexDecomposition, FitsACorridorTightly)
{
  Cloud walls;
  for (double x = -4.0; x <= 6.0; x += 0.2)
    for (double z = -3.0; z <= 3.0; z += 0.2)
    {
      walls.emplace_back(x, 1.0, z);
      walls.emplace_back(x, -1.0, z);
    }
  const FreePolyhedron free = decompose({0, 0, 0}, {2, 0, 0}, walls, {1.0, 2.0, 1.0, 0.3});
  EXPECT_TRUE(free.contains_seed);
  // The planes of the walls, and none askew: the set is the corridor.
  EXPECT_NEAR(free.set.violation({3.0, 0.7, 1.0}), 0.0, 0.15);
  EXPECT_NEAR(free.set.violation({1.0, 0.7, 0.0}), 0.0, 1e-6);
  EXPECT_NEAR(free.set.violation({1.0, -0.7, 0.0}), 0.0, 1e-6);
}

TEST(ConvexDecomposition, StaysFiniteOnDegenerateInput)
{
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double inf = std::numeric_limits<double>::infinity();
  const Eigen::Vector3d a(0, 0, 0), b(1, 0, 0);
  const std::vector<Cloud> clouds = {
      {},
      {a},
      {b},
      {0.5 * (a + b)},
      {a, b, 0.5 * (a + b), {0.25, 1e-12, 0}, {0.25, 0, 1e-7}},
      {{nan, 0, 0}, {inf, 0, 0}, {0.5, -inf, 0}},
      Cloud(100, Eigen::Vector3d(0.3, 0.1, 0.0)),
  };
  for (const Cloud& cloud : clouds)
    for (const Eigen::Vector3d& end :
         {a, b, Eigen::Vector3d(0, 0, 1e-9), Eigen::Vector3d(0, 0, -2)})
      for (const double shrink : {0.0, 0.5})
      {
        const FreePolyhedron free = decompose(a, end, cloud, {1.0, 1.0, 1.0, shrink});
        EXPECT_TRUE(free.set.A.allFinite());
        EXPECT_TRUE(free.set.b.allFinite());
        EXPECT_GE(free.set.rows(), 6);
        for (Eigen::Index i = 0; i < free.set.rows(); ++i)
          EXPECT_NEAR(free.set.A.row(i).norm(), 1.0, 1e-12);
        for (const Eigen::Vector3d& o : cloud)
        {
          EXPECT_TRUE(!o.allFinite() || free.set.violation(o) >= -1e-9);
        }
      }
  EXPECT_FALSE(decompose(a, b, {0.5 * (a + b)}, {1.0, 1.0, 1.0, 0.2}).contains_seed);
}

TEST(ConvexDecomposition, DoesNotDependOnTheNumberOfThreads)
{
  for (std::uint64_t seed = 0; seed < 20; ++seed)
  {
    SCOPED_TRACE(seed);
    Rng rng(seed);
    Eigen::Matrix3Xd path(3, 9);
    std::vector<Cloud> clouds(8);
    for (Eigen::Index i = 0; i < 9; ++i) path.col(i) << static_cast<double>(i), rng.uniform(), 1.0;
    for (Cloud& cloud : clouds)
      for (int i = 0; i < 300; ++i)
        cloud.emplace_back(rng.uniform(-1, 9), rng.uniform(-3, 4), rng.uniform(-1, 3));
    const auto serial = decomposeParallel(path, clouds, {}, 1);
    ASSERT_EQ(serial.size(), clouds.size());
    for (const int threads : {2, 3, 16})
    {
      const auto parallel = decomposeParallel(path, clouds, {}, threads);
      for (std::size_t i = 0; i < serial.size(); ++i)
      {
        EXPECT_EQ(parallel[i].set.A, serial[i].set.A);
        EXPECT_EQ(parallel[i].set.b, serial[i].set.b);
        EXPECT_EQ(parallel[i].contains_seed, serial[i].contains_seed);
      }
    }
    const auto k = static_cast<Eigen::Index>(seed % 8);
    const FreePolyhedron alone =
        decompose(path.col(k), path.col(k + 1), clouds[static_cast<std::size_t>(k)], {});
    EXPECT_EQ(alone.set.A, serial[static_cast<std::size_t>(k)].set.A);
  }
}

TEST(ConvexDecomposition, RefusesMisuse)
{
  const Eigen::Vector3d a(0, 0, 0), b(1, 0, 0);
  EXPECT_THROW((void)decompose(a, b, {}, {0.0, 1.0, 1.0, 0.0}), std::invalid_argument);
  EXPECT_THROW((void)decompose(a, b, {}, {1.0, 1.0, 1.0, -0.1}), std::invalid_argument);
  EXPECT_THROW((void)decompose(a, Eigen::Vector3d::Constant(NAN), {}, {}), std::invalid_argument);
  const Eigen::Matrix3Xd path = Eigen::Matrix3Xd::Random(3, 3);
  EXPECT_THROW((void)decomposeParallel(path, {{}}, {}, 1), std::invalid_argument);
  EXPECT_THROW((void)decomposeParallel(path, {{}, {}}, {}, 0), std::invalid_argument);
  EXPECT_TRUE(decomposeParallel(Eigen::Matrix3Xd(3, 1), {}, {}, 1).empty());
}

}  // namespace
}  // namespace slalom::geometry
