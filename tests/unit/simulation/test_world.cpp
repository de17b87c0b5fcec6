// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

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

struct Scene
{
  std::vector<Tree> trees;
  std::vector<Box> boxes;

  [[nodiscard]] World world(bool ground) const { return World::of(trees, boxes, ground); }

  /// Independent of the library: is p in a solid?
  [[nodiscard]] bool solid(const Vector3d& p, bool ground) const
  {
    for (const Tree& t : trees)
      if ((p.head<2>() - t.centre_W).squaredNorm() <= t.radius * t.radius && p.z() >= 0.0 &&
          p.z() <= t.height)
        return true;
    for (const Box& b : boxes)
      if (b.contains(p)) return true;
    return ground && p.z() < 0.0;
  }
};

Scene randomScene(Rng& rng)
{
  Scene scene;
  for (int k = rng.integer(1, 40); k > 0; --k)
    scene.trees.push_back({{rng.uniform(-12.0, 12.0), rng.uniform(-12.0, 12.0)},
                           rng.uniform(0.05, 1.5),
                           rng.uniform(1.0, 9.0)});
  for (int k = rng.integer(0, 6); k > 0; --k)
  {
    const Vector3d corner = rng.uniform3(-10.0, 10.0);
    scene.boxes.push_back(Box(corner, corner + rng.uniform3(0.1, 5.0)));
  }
  return scene;
}

/// A ray from anywhere, now and then along an axis, down a column or outside of everything.
std::pair<Vector3d, Vector3d> randomRay(Rng& rng)
{
  Vector3d origin = rng.uniform3(-16.0, 16.0), direction = rng.direction();
  const int kind = rng.integer(0, 5);
  if (kind == 0) direction = Vector3d::Unit(rng.integer(0, 2)) * (rng.uniform() < 0.5 ? -1 : 1);
  if (kind == 1) direction[rng.integer(0, 2)] = 0.0;
  if (kind == 2) origin.z() = rng.uniform(0.5, 3.0);
  return {origin, direction.normalized()};
}

TEST(World, RayEndsWhereMarchingFindsTheFirstSolid)
{
  for (std::uint64_t seed = 0; seed < 30; ++seed)
  {
    SCOPED_TRACE(seed);
    Rng rng(seed);
    const Scene scene = randomScene(rng);
    const bool ground = rng.uniform() < 0.5;
    const World world = scene.world(ground);
    constexpr double kStep = 5e-3, kRange = 30.0;
    for (int k = 0; k < 40; ++k)
    {
      const auto [origin, direction] = randomRay(rng);
      const std::optional<double> hit = world.castRay(origin, 3.0 * direction, kRange);
      // Nothing solid before the hit, solid just behind it.
      const double end = hit.value_or(kRange);
      bool clear = true;
      for (double t = 0.0; t < end - 1e-9 && clear; t += kStep)
        clear = !scene.solid(origin + t * direction, ground);
      EXPECT_TRUE(clear) << "ray " << k << " passes through a solid before " << end;
      if (!hit) continue;
      EXPECT_TRUE(scene.solid(origin + *hit * direction, ground) ||
                  scene.solid(origin + (*hit + 1e-9) * direction, ground))
          << "ray " << k << " ends in the air at " << *hit;
    }
  }
}

TEST(World, RangeLimitsARayExactly)
{
  const World world = World::of({{{5.0, 0.0}, 1.0, 3.0}}, {}, false);
  const Vector3d origin(0.0, 0.0, 1.0), along = Vector3d::UnitX();
  ASSERT_TRUE(world.castRay(origin, along, 10.0));
  EXPECT_NEAR(*world.castRay(origin, along, 10.0), 4.0, 1e-12);
  EXPECT_TRUE(world.castRay(origin, along, 4.0));
  EXPECT_FALSE(world.castRay(origin, along, 3.9999));
  EXPECT_EQ(world.castRay({5.0, 0.0, 1.0}, along, 1.0), 0.0);
}

TEST(World, DistanceIsToTheNearestSurfacePoint)
{
  for (std::uint64_t seed = 100; seed < 120; ++seed)
  {
    SCOPED_TRACE(seed);
    Rng rng(seed);
    const Scene scene = randomScene(rng);
    const World world = scene.world(false);
    for (int k = 0; k < 60; ++k)
    {
      const Vector3d p = rng.uniform3(-20.0, 20.0);
      const double d = world.distance(p);
      EXPECT_EQ(d <= 0.0, scene.solid(p, false));
      if (d <= 0.0) continue;
      // No solid inside the ball, one on its surface: the ray towards it ends at d.
      double nearest = 1e9;
      for (int i = 0; i < 400; ++i)
      {
        const Vector3d q = p + rng.direction() * d * std::cbrt(rng.uniform()) * (1.0 - 1e-9);
        EXPECT_FALSE(scene.solid(q, false));
      }
      for (const Tree& t : scene.trees)
      {
        Vector3d q;
        const Eigen::Vector2d away = p.head<2>() - t.centre_W;
        q.head<2>() = t.centre_W + away * std::min(1.0, t.radius / away.norm());
        q.z() = std::clamp(p.z(), 0.0, t.height);
        nearest = std::min(nearest, (p - q).norm());
      }
      for (const Box& b : scene.boxes) nearest = std::min(nearest, b.exteriorDistance(p));
      EXPECT_NEAR(d, nearest, 1e-9);
    }
  }
}

TEST(World, DistanceInsideIsTheWayOut)
{
  const World world =
      World::of({{{0.0, 0.0}, 1.0, 4.0}}, {Box(Vector3d(5, 5, 5), Vector3d(9, 8, 7))}, true);
  EXPECT_NEAR(world.distance({0.2, 0.0, 2.0}), -0.8, 1e-12);
  EXPECT_NEAR(world.distance({0.0, 0.0, 3.9}), -0.1, 1e-12);
  EXPECT_NEAR(world.distance({5.5, 6.5, 6.0}), -0.5, 1e-12);
}

TEST(World, GroundCountsOnlyWhenAskedFor)
{
  const World world = World::of({{{10.0, 0.0}, 1.0, 4.0}}, {}, true);
  EXPECT_NEAR(world.distance({0.0, 0.0, 0.5}, true), 0.5, 1e-12);
  EXPECT_NEAR(world.distance({0.0, 0.0, 0.5}, false), 9.0, 1e-12);
  EXPECT_LT(world.distance({0.0, 0.0, -0.5}, true), 0.0);
  EXPECT_NEAR(*world.castRay({0.0, 0.0, 2.0}, -Vector3d::UnitZ(), 5.0), 2.0, 1e-12);
  EXPECT_EQ(World::of({}, {}, false).distance(Vector3d::Zero(), true),
            std::numeric_limits<double>::infinity());
}

TEST(World, BoundsHoldTheShapesAndAMargin)
{
  const World world = World::of({{{10.0, -4.0}, 1.0, 4.0}}, {}, true);
  EXPECT_TRUE(world.bounds().min().isApprox(Vector3d(7.0, -7.0, -2.0)));
  EXPECT_TRUE(world.bounds().max().isApprox(Vector3d(13.0, -1.0, 6.0)));
}

TEST(WorldFile, TreesOfACsvStandOnTheGround)
{
  const TempFile file("w.csv", "x,y,radius,height\r\n1.5,2,0.25,7\n\n# comment\n-3,-4,0.5,3\n");
  const World world = World::load(file.path());
  EXPECT_TRUE(world.hasGround());
  EXPECT_NEAR(world.distance({1.5, 4.0, 3.0}), 1.75, 1e-12);
  EXPECT_NEAR(world.distance({-3.0, -4.0, 5.0}), 2.0, 1e-12);
}

TEST(WorldFile, IniHoldsTreesBoxesAndTheGround)
{
  const TempFile file(
      "w.ini",
      "[world]\nground = false\n[tree.oak]\nx = 1\ny = 2\nradius = 0.5\nheight = 6\n"
      "[box.wall]\nmin = -5, -5, 0\nmax = -4,5,3\n");
  const World world = World::load(file.path());
  EXPECT_FALSE(world.hasGround());
  EXPECT_NEAR(world.distance({1.0, 4.0, 1.0}), 1.5, 1e-12);
  EXPECT_NEAR(world.distance({-3.0, 0.0, 1.0}), 1.0, 1e-12);
}

TEST(WorldFile, MalformedCsvNamesFileLineAndValue)
{
  const std::pair<const char*, std::vector<const char*>> cases[] = {
      {"x,y,radius\n1,2,3\n", {"w.csv:1", "x,y,radius,height"}},
      {"x,y,radius,height\n1,2,0.3,4\n1,abc,0.3,4\n", {"w.csv:3", "'abc'"}},
      {"x,y,radius,height\n1,2,0.3\n", {"w.csv:2", "3 fields"}},
      {"x,y,radius,height\n1,2,-0.3,4\n", {"w.csv:2", "radius = -0.3"}},
      {"x,y,radius,height\n1,2,0.3,0\n", {"w.csv:2", "height = 0"}},
      {"x,y,radius,height\n1,nan,0.3,4\n", {"w.csv:2", "'nan'"}},
      {"x,y,radius,height\n1,2 3,0.3,4\n", {"w.csv:2", "'2 3'"}},
      {"# nothing\n", {"w.csv:1"}},
  };
  for (const auto& [text, parts] : cases)
  {
    SCOPED_TRACE(text);
    const TempFile file("w.csv", text);
    const std::string message = messageOf([&] { (void)World::load(file.path()); });
    for (const char* part : parts) EXPECT_THAT(message, HasSubstr(part));
  }
}

TEST(WorldFile, MalformedIniNamesFileLineKeyAndValue)
{
  const std::pair<const char*, std::vector<const char*>> cases[] = {
      {"[tree.a]\nx = 1\ny = 2\nradius = 0.5\n", {"[tree.a]", "height"}},
      {"[tree.a]\nx = 1\ny = 2\nradius = -1\nheight = 3\n", {"w.ini:4", "radius", "-1"}},
      {"[tree.a]\nx = one\ny = 2\nradius = 1\nheight = 3\n", {"w.ini:2", "x = one"}},
      {"[box.a]\nmin = 0,0,0\nmax = 1,1\n", {"w.ini:3", "1,1"}},
      {"[box.a]\nmin = 0,0,0\nmax = 1,0,1\n", {"w.ini:3", "max"}},
      {"[box.a]\nmin = 0,0,0\nmax = 1,1,1\ncolour = red\n", {"w.ini:4", "colour"}},
      {"[sphere.a]\nx = 1\n", {"[sphere.a]"}},
      {"[world]\nground = maybe\n", {"w.ini:2", "maybe"}},
  };
  for (const auto& [text, parts] : cases)
  {
    SCOPED_TRACE(text);
    const TempFile file("w.ini", text);
    const std::string message = messageOf([&] { (void)World::load(file.path()); });
    for (const char* part : parts) EXPECT_THAT(message, HasSubstr(part));
  }
}

TEST(WorldFile, MissingOrForeignFilesAreRefusedByName)
{
  EXPECT_THAT(messageOf([] { (void)World::load("/nowhere/w.csv"); }), HasSubstr("/nowhere/w.csv"));
  EXPECT_THAT(messageOf([] { (void)World::load("/nowhere/w.bt"); }), HasSubstr("/nowhere/w.bt"));
  EXPECT_THAT(messageOf([] { (void)World::load("w.stl"); }), HasSubstr(".stl"));
}
}  // namespace
}  // namespace slalom::simulation
