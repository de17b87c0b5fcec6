// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>
#include <iostream>
#include <limits>
#include <numbers>
#include <vector>

#include "SharedData.h"
#include "slalom/core/Rng.h"
#include "slalom/core/TextTable.h"
#include "slalom/simulation/Forest.h"
#include "slalom/simulation/ShortestPath.h"

namespace slalom::simulation
{
namespace
{
using Eigen::Vector3d;

/// Least distance of the route from solids, sampled every centimetre.
double clearanceOf(const World& world, const Eigen::Matrix3Xd& route)
{
  double least = std::numeric_limits<double>::infinity();
  for (Eigen::Index k = 1; k < route.cols(); ++k)
  {
    const Vector3d leg = route.col(k) - route.col(k - 1);
    const int parts = static_cast<int>(std::ceil(leg.norm() / 0.01)) + 1;
    for (int i = 0; i <= parts; ++i)
      least = std::min(least, world.distance(route.col(k - 1) + leg * (double(i) / parts)));
  }
  return least;
}

double lengthOf(const Eigen::Matrix3Xd& route)
{
  double length = 0.0;
  for (Eigen::Index k = 1; k < route.cols(); ++k)
    length += (route.col(k) - route.col(k - 1)).norm();
  return length;
}

TEST(ShortestPath, GoesAroundOneTrunkByTangentsAndArc)
{
  for (std::uint64_t seed = 1; seed <= 20; ++seed)
  {
    SCOPED_TRACE(seed);
    core::Rng rng(seed);
    const double radius = rng.uniform(0.2, 0.6), trunk = rng.uniform(0.1, 0.8);
    const double reach = radius + trunk;
    const double a = rng.uniform(1.1, 6.0) * reach, b = rng.uniform(1.1, 6.0) * reach;
    const double turn =
        rng.uniform(2.2, std::numbers::pi);  // between the ends, seen from the trunk
    const double first = rng.uniform(-3.0, 3.0);
    const World world = World::of({{{1.0, -2.0}, trunk, 6.0}}, {}, true);
    const Vector3d centre(1.0, -2.0, 1.5);
    const Vector3d start = centre + a * Vector3d(std::cos(first), std::sin(first), 0.0);
    const Vector3d goal =
        centre + b * Vector3d(std::cos(first + turn), std::sin(first + turn), 0.0);
    const double arc = turn - std::acos(reach / a) - std::acos(reach / b);
    const double exact = arc > 0.0 ? std::sqrt(a * a - reach * reach) +
                                         std::sqrt(b * b - reach * reach) + reach * arc
                                   : (goal - start).norm();
    const auto length = shortestPath(world, start, goal, radius);
    ASSERT_TRUE(length);
    EXPECT_NEAR(*length, exact, 1e-3 * exact);
  }
}

TEST(ShortestPath, IsFreeAndNotShorterThanStraightAndTheSameBothWays)
{
  for (std::uint64_t seed = 1; seed <= 6; ++seed)
  {
    SCOPED_TRACE(seed);
    ForestConfig forest;
    forest.size_m = 16.0;
    forest.density_per_m2 = 0.3;
    const World world = World::of(makeForest(forest, seed), {}, true);
    const Vector3d start(-7.0, 0.0, 1.5), goal(7.0, 0.0, 1.5);
    double before = 14.0;
    for (const double radius : {0.0, 0.2, 0.3, 0.4, 0.5})
    {
      const auto route = shortestRoute(world, start, goal, radius);
      if (!route) break;  // and no way for a larger one
      EXPECT_GE(clearanceOf(world, *route), radius - 1e-3) << radius;
      EXPECT_EQ(route->col(0), start);
      EXPECT_LT((route->rightCols<1>() - goal).norm(), 1e-9);
      const double length = lengthOf(*route);
      EXPECT_GE(length, before * (1.0 - 2e-3)) << radius;
      before = length;
      const auto back = shortestPath(world, goal, start, radius);
      ASSERT_TRUE(back);
      EXPECT_NEAR(*back, length, 5e-3 * length) << radius;
    }
  }
}

TEST(ShortestPath, FindsGapsThatFallBetweenNodesAndNoneThatAreTooNarrow)
{
  for (std::uint64_t seed = 1; seed <= 10; ++seed)
  {
    SCOPED_TRACE(seed);
    core::Rng rng(seed);
    // A wall across the world with one gap between two trunks; outside the bounds there is no way.
    const double y = rng.uniform(-1.0, 1.0), half = 0.3 + 0.5;
    const auto gate = [&](double spare)
    {
      Shapes shapes;
      const double off = half + 0.5 * spare;
      shapes.trees = {{{0.1, y - off}, 0.5, 6.0}, {{0.1, y + off}, 0.5, 6.0}};
      shapes.boxes = {Box(Vector3d(0.0, -30.0, 0.0), Vector3d(0.2, y - off, 6.0)),
                      Box(Vector3d(0.0, y + off, 0.0), Vector3d(0.2, 30.0, 6.0)),
                      Box(Vector3d(-5.0, 28.0, 0.0), Vector3d(5.0, 30.0, 6.0)),
                      Box(Vector3d(-5.0, -30.0, 0.0), Vector3d(5.0, -28.0, 6.0))};
      shapes.boxes.push_back(Box(Vector3d(-5.0, -30.0, 0.0), Vector3d(-4.8, 30.0, 6.0)));
      shapes.boxes.push_back(Box(Vector3d(4.8, -30.0, 0.0), Vector3d(5.0, 30.0, 6.0)));
      return World::of(std::move(shapes));
    };
    const Vector3d start(-3.0, 0.3, 1.5), goal(3.0, -0.2, 1.5);
    EXPECT_TRUE(shortestPath(gate(0.005), start, goal, 0.3));
    EXPECT_FALSE(shortestPath(gate(-0.005), start, goal, 0.3));
  }
}

TEST(ShortestPath, RefusesEndsThatAreNotFree)
{
  const World world = World::of({{{0.0, 0.0}, 0.5, 6.0}}, {}, true);
  const Vector3d in(0.6, 0.0, 1.5), out(5.0, 0.0, 1.5);
  EXPECT_FALSE(shortestPath(world, in, out, 0.3));
  EXPECT_FALSE(shortestPath(world, out, in, 0.3));
  EXPECT_EQ(shortestPath(world, out, out, 0.3), 0.0);
  // Straight up is a plane, too.
  EXPECT_NEAR(*shortestPath(world, out, out + Vector3d(0.0, 0.0, 2.0), 0.3), 2.0, 1e-9);
}

TEST(MakeSolvableForest, HasTheWayThatItReports)
{
  ForestConfig config;
  config.size_m = 12.0;
  config.density_per_m2 = 0.35;
  config.min_gap_m = 0.0;
  int rejected = 0;
  for (std::uint64_t seed = 1; seed <= 4; ++seed)
  {
    SCOPED_TRACE(seed);
    const SolvableForest forest = makeSolvableForest(config, seed, 0.5);
    rejected += forest.rejected;
    EXPECT_EQ(forest.rejected == 0, forestCsv(forest.trees) == forestCsv(makeForest(config, seed)));
    EXPECT_EQ(forestCsv(forest.trees), forestCsv(makeSolvableForest(config, seed, 0.5).trees));
    EXPECT_GE(forest.shortest_m, 10.0);
    const auto free =
        shortestPath(World::of(forest.trees, {}, true), {-5.0, 0.0, 1.5}, {5.0, 0.0, 1.5}, 0.5);
    ASSERT_TRUE(free);
    EXPECT_LE(*free, 1.005 * forest.shortest_m) << "who may leave the square is no slower";
  }
  EXPECT_GT(rejected, 0) << "some forests have no way within the square";
}

/// The forests with known shortest paths: never longer, and free, hence never wrong. Where it is
/// shorter by more than 0.5 % it found a gap that the tabulated search did not.
TEST(ShortestPath, IsNotLongerThanWhatIsKnownOfTheForests)
{
  const auto folder = test::sharedData("forests/random");
  if (!exists(folder / "meta.csv")) GTEST_SKIP() << folder;
  int agreeing = 0, forests = 0;
  const auto rows = core::readRows(folder / "meta.csv", ',');
  for (std::size_t k = 1; k < rows.size(); ++k)
  {
    const auto number = [&](std::size_t field)
    { return core::numberAt(folder / "meta.csv", rows[k], field); };
    const World world = World::load(folder / (rows[k].fields[0] + ".csv"));
    const Vector3d start(number(4), number(5), number(6)), goal(number(7), number(8), number(9));
    for (const auto& [radius, field] : {std::pair(0.3, 11), std::pair(0.5, 12)})
    {
      SCOPED_TRACE(rows[k].fields[0] + " radius " + std::to_string(radius));
      const double known = number(static_cast<std::size_t>(field));
      const auto route = shortestRoute(world, start, goal, radius);
      ASSERT_TRUE(route);
      const double length = lengthOf(*route);
      EXPECT_LE(length, 1.005 * known);
      EXPECT_GE(length, (goal - start).norm());
      EXPECT_GE(clearanceOf(world, *route), radius - 1e-3);
      ++forests;
      if (std::abs(length - known) <= 5e-3 * known)
        ++agreeing;
      else
        std::cout << rows[k].fields[0] << " radius " << radius << ": known " << known
                  << " m, found " << length << " m\n";
    }
  }
  EXPECT_GE(agreeing, forests - 2);
}
/// Of the points in the plane of the flight, by the definition: nobody has to search where all that
/// is free is connected.
Vector3d nearestByBruteForce(const World& world, const Vector3d& goal, const Vector3d& from,
                             double clearance)
{
  constexpr double kStep = 0.02, kReach = 4.0;
  std::vector<Vector3d> free;
  double least = std::numeric_limits<double>::infinity();
  for (double x = -kReach; x <= kReach; x += kStep)
    for (double y = -kReach; y <= kReach; y += kStep)
      if (const Vector3d p = goal + Vector3d(x, y, 0.0); world.distance(p) >= clearance)
      {
        free.push_back(p);
        least = std::min(least, (p - goal).norm());
      }
  Vector3d best = Vector3d::Constant(1e9);
  for (const Vector3d& p : free)
    if ((p - goal).norm() <= least + kStep && (p - from).norm() < (best - from).norm()) best = p;
  return best;
}

TEST(NearestReachable, IsTheFreePointNextToTheGoalAndToTheVehicle)
{
  for (std::uint64_t seed = 1; seed <= 20; ++seed)
  {
    SCOPED_TRACE(seed);
    core::Rng rng(seed);
    const double trunk = rng.uniform(0.5, 1.5), clearance = rng.uniform(0.4, 1.0);
    const Vector3d goal(10.0, rng.uniform(-2.0, 2.0), 1.5);
    // Inside the trunk, and mostly not in its middle.
    const Eigen::Vector2d centre(goal.x() + rng.uniform(-0.4, 0.4),
                                 goal.y() + rng.uniform(-0.4, 0.4));
    const World world = World::of({{centre, trunk, 6.0}, {{5.0, 0.3}, 0.4, 6.0}}, {}, true);
    const double way = rng.uniform(-3.1, 3.1);
    const Vector3d from = goal + 2.6 * Vector3d(std::cos(way), std::sin(way), 0.0);
    const auto best = nearestReachable(world, {0.0, 0.0, 1.5}, goal, from, 0.35, clearance);
    ASSERT_TRUE(best);
    EXPECT_GE(world.distance(*best), clearance - 1e-3);
    const Vector3d wanted = nearestByBruteForce(world, goal, from, clearance);
    EXPECT_NEAR((*best - goal).norm(), (wanted - goal).norm(), 0.08);
    EXPECT_LE((*best - from).norm(), (wanted - from).norm() + 0.08);
  }
  const World trunk = World::of({{{10.0, 0.0}, 1.5, 6.0}}, {}, true);
  for (const double way : {-3.0, -1.2, 0.0, 0.7, 2.0})
  {
    SCOPED_TRACE(way);
    const Vector3d goal(10.0, 0.0, 1.5), out(std::cos(way), std::sin(way), 0.0);
    const auto best = nearestReachable(trunk, {0.0, 0.0, 1.5}, goal, goal + 3.0 * out, 0.35, 0.8);
    ASSERT_TRUE(best);
    EXPECT_LE((*best - (goal + 2.3 * out)).norm(), 0.1) << "any point of the circle will do";
  }
}

TEST(NearestReachable, DoesNotLookBehindAWallWithoutAWayThrough)
{
  // A room around the goal whose door is 1.1 m wide, or shut.
  const auto wall = [](double x0, double y0, double x1, double y1)
  { return Box(Vector3d(x0, y0, 0.0), Vector3d(x1, y1, 6.0)); };
  const auto room = [&wall](bool open)
  {
    std::vector<Box> boxes{wall(8.0, -3.0, 14.0, -2.8), wall(8.0, 2.8, 14.0, 3.0),
                           wall(13.8, -3.0, 14.0, 3.0), wall(8.0, -3.0, 8.2, 0.5),
                           wall(8.0, 1.6, 8.2, 3.0)};
    if (!open) boxes.push_back(wall(8.0, 0.5, 8.2, 1.6));
    return World::of({}, boxes, true);
  };
  const Vector3d start(0.0, 0.0, 1.5), goal(11.0, 0.0, 1.5);
  const auto inside = nearestReachable(room(true), start, goal, start, 0.35, 0.8);
  ASSERT_TRUE(inside);
  EXPECT_LE((*inside - goal).norm(), 0.08);
  const auto outside = nearestReachable(room(true), start, goal, start, 0.6, 0.8);
  ASSERT_TRUE(outside) << "too wide for the door";
  EXPECT_GE(room(true).distance(*outside), 0.8 - 1e-3);
  const World open = room(true);
  double least = std::numeric_limits<double>::infinity();  // of the points before the wall
  for (double x = 6.0; x <= 8.0; x += 0.02)
    for (double y = -3.0; y <= 3.0; y += 0.02)
      if (const Vector3d p(x, y, 1.5); open.distance(p) >= 0.8)
        least = std::min(least, (p - goal).norm());
  EXPECT_NEAR((*outside - goal).norm(), least, 0.08);
  EXPECT_LT(outside->x(), 8.0);
  const auto shut = nearestReachable(room(false), start, goal, start, 0.35, 0.8);
  ASSERT_TRUE(shut);
  EXPECT_NEAR(shut->x(), 7.2, 0.1);
  EXPECT_FALSE(nearestReachable(room(true), {8.1, -2.0, 1.5}, goal, start, 0.35, 0.8));
}

}  // namespace
}  // namespace slalom::simulation
