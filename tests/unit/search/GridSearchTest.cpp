// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <queue>
#include <stdexcept>
#include <thread>
#include <tuple>

#include "SearchChecks.h"
#include "slalom/core/Rng.h"
#include "slalom/search/GridSearch.h"

namespace slalom::search
{
namespace
{
using core::Rng;
using core::UnknownAs;
using test::AnalyticField;
using test::InterpolatedField;
using test::Obstacle;
using Box = Eigen::AlignedBox3d;
using Vec = Eigen::Vector3d;

double costPerMetre(const core::DistanceField& field, const Vec& p, const GridSearchConfig& config)
{
  const double near = config.preferred_clearance_m - clearanceOf(field, p);
  const double span = config.preferred_clearance_m - config.clearance_m;
  return near > 0.0 && span > 0.0 ? 1.0 + config.proximity_weight * near / span : 1.0;
}

/// Lattice around the start as findPath() promises it: every point, by brute force.
struct BruteForce
{
  using Key = std::tuple<int, int, int>;
  std::map<Key, double> cost;  ///< of every reachable point
  double to_goal = std::numeric_limits<double>::infinity();

  static Vec place(const Key& k, const Vec& start, double r)
  {
    return start + r * Vec(std::get<0>(k), std::get<1>(k), std::get<2>(k));
  }
  /// Distance of the reachable point nearest to the goal.
  [[nodiscard]] double nearest(const Vec& start, const Vec& goal) const
  {
    double nearest = std::numeric_limits<double>::infinity();
    for (const auto& [key, g] : cost)
      nearest = std::min(nearest, (place(key, start, 0.2) - goal).norm());
    return nearest;
  }
  BruteForce(const core::DistanceField& field, const Vec& start, const Vec& goal, const Box& box,
             const GridSearchConfig& config)
  {
    const double r = field.resolution(), clearance = config.clearance_m;
    const auto edge = [&](const Vec& a, const Vec& b)
    {
      return (b - a).norm() * 0.5 *
             (costPerMetre(field, a, config) + costPerMetre(field, b, config));
    };
    using Item = std::pair<double, Key>;
    std::priority_queue<Item, std::vector<Item>, std::greater<>> open;
    cost[{0, 0, 0}] = 0.0;
    open.push({0.0, {0, 0, 0}});
    while (!open.empty())
    {
      const auto [g, key] = open.top();
      open.pop();
      if (g > cost[key]) continue;
      const Vec here = place(key, start, r);
      if ((goal - here).cwiseAbs().maxCoeff() <= r &&
          sampledClearance(field, here, goal, 0.02) >= clearance)
        to_goal = std::min(to_goal, g + edge(here, goal));
      for (int n = 0; n < 27; ++n)
      {
        const Key next = {std::get<0>(key) + n % 3 - 1, std::get<1>(key) + n / 3 % 3 - 1,
                          std::get<2>(key) + n / 9 - 1};
        const Vec there = place(next, start, r);
        if (n == 13 || !box.contains(there)) continue;
        if (clearanceOf(field, there) < clearance) continue;
        const double g_next = g + edge(here, there);
        const auto known = cost.find(next);
        if (known != cost.end() && known->second <= g_next + 1e-12) continue;
        if (sampledClearance(field, here, there, 0.05) < clearance) continue;
        cost[next] = g_next;
        open.push({g_next, next});
      }
    }
  }
};

TEST(GridSearch, PathsKeepTheClearanceInRandomForests)
{
  int found = 0, bent = 0;
  for (std::uint64_t seed = 0; seed < 60; ++seed)
  {
    SCOPED_TRACE(seed);
    Rng rng(seed);
    const AnalyticField field(forest(rng, 25, 5.0));
    const Box box(Vec(-5, -5, 0), Vec(5, 5, 2));
    const Vec start(-4.5, rng.uniform(-4, 4), 1.0), goal(4.5, rng.uniform(-4, 4), 1.0);
    GridSearchConfig config;
    config.proximity_weight = rng.integer(0, 1) == 0 ? 0.0 : rng.uniform(0.0, 4.0);
    config.clearance_m = rng.uniform(0.2, 0.6);
    const SearchResult result = findPath(field, start, goal, box, config);
    if (clearanceOf(field, start) < config.clearance_m)
    {
      EXPECT_EQ(result.status, SearchStatus::StartBlocked);
    }
    if (result.status != SearchStatus::Found)
    {
      EXPECT_EQ(result.path.cols(), 0);
      continue;
    }
    ++found;
    bent += result.path.cols() > 2 ? 1 : 0;
    expectValidPath(field, result, start, goal, box, config.clearance_m);
  }
  EXPECT_GT(found, 25);
  EXPECT_GT(bent, 15);
}

TEST(GridSearch, PathsKeepTheClearanceInAnInterpolatedField)
{
  int found = 0;
  for (std::uint64_t seed = 0; seed < 100; ++seed)
  {
    SCOPED_TRACE(seed);
    Rng rng(seed);
    const Box box(Vec(-5, -5, 0), Vec(5, 5, 2));
    const InterpolatedField field(AnalyticField(forest(rng, 25, 5.0)), box, 0.2);
    const Vec start(-4.5, rng.uniform(-4, 4), 1.0), goal(4.5, rng.uniform(-4, 4), 1.0);
    GridSearchConfig config;
    config.clearance_m = rng.uniform(0.05, 0.6);
    const SearchResult result = findPath(field, start, goal, box, config);
    if (result.status != SearchStatus::Found) continue;
    ++found;
    expectValidPath(field, result, start, goal, box, config.clearance_m);
  }
  EXPECT_GT(found, 50);
}

TEST(GridSearch, LengthIsNearTheOptimumOfTheLattice)
{
  int compared = 0, unreachable = 0;
  for (std::uint64_t seed = 0; seed < 30; ++seed)
  {
    SCOPED_TRACE(seed);
    Rng rng(seed);
    const Box box(Vec(-2, -2, 0.5), Vec(2, 2, 1.5));
    const InterpolatedField field(AnalyticField(forest(rng, 9, 2.0)), box, 0.2);
    const Vec start(-1.9, rng.uniform(-1.8, 1.8), 1.0);
    const Vec goal(1.9, rng.uniform(-1.8, 1.8), rng.uniform(0.7, 1.3));
    GridSearchConfig config;
    config.clearance_m = 0.25;
    config.proximity_weight = 0.0;
    if (clearanceOf(field, start) < 0.25 || clearanceOf(field, goal) < 0.25) continue;
    const SearchResult result = findPath(field, start, goal, box, config);
    const BruteForce brute(field, start, goal, box, config);
    if (result.status == SearchStatus::Unreachable)
    {
      // A gap exactly as wide as the clearance may be judged either way; none here is.
      EXPECT_TRUE(std::isinf(brute.to_goal));
      ++unreachable;
      continue;
    }
    ASSERT_EQ(result.status, SearchStatus::Found);
    ++compared;
    EXPECT_LE(result.length_m, 1.05 * brute.to_goal);
    EXPECT_GE(result.length_m, (goal - start).norm() - 1e-9);
  }
  EXPECT_GT(compared, 10);
}

/// In low boxes, where the view from above tells most, and in high ones, where it does not.
TEST(GridSearch, CostIsWithinItsBoundOfTheLattice)
{
  // Costs are summed at the middles of the pieces here and at the ends there.
  constexpr double kSums = 1.02;
  int compared[2] = {0, 0};
  for (std::uint64_t seed = 0; seed < 60; ++seed)
  {
    SCOPED_TRACE(seed);
    Rng rng(seed);
    const bool high = seed % 3 == 0;
    const Box box =
        high ? Box(Vec(-1.2, -1.2, 0), Vec(1.2, 1.2, 5.2)) : Box(Vec(-2, -2, 0.5), Vec(2, 2, 1.5));
    std::vector<Obstacle> obstacles = forest(rng, high ? 2 : 7, high ? 1.0 : 2.0);
    // Not upright everywhere.
    for (int i = 0; i < 3; ++i)
      obstacles.push_back(test::Sphere{
          {rng.uniform(-2, 2), rng.uniform(-2, 2), rng.uniform(box.min().z(), box.max().z())},
          rng.uniform(0.1, 0.4)});
    const InterpolatedField field((AnalyticField(obstacles)), box, 0.2);
    Vec start(box.min().x() + 0.1, 0, 0), goal(box.max().x() - 0.1, 0, 0);
    for (Vec* end : {&start, &goal})
    {
      end->y() = rng.uniform(0.9 * box.min().y(), 0.9 * box.max().y());
      end->z() = rng.uniform(box.min().z(), box.max().z());
    }
    GridSearchConfig config;
    config.clearance_m = 0.25;
    config.preferred_clearance_m = rng.uniform(0.3, 0.8);
    config.proximity_weight = rng.uniform(0.5, 4.0);
    if (clearanceOf(field, start) < 0.25 || clearanceOf(field, goal) < 0.25) continue;
    const SearchResult result = findPath(field, start, goal, box, config);
    const BruteForce brute(field, start, goal, box, config);
    ASSERT_EQ(result.status == SearchStatus::Found, !std::isinf(brute.to_goal));
    if (result.status != SearchStatus::Found) continue;
    ++compared[high ? 1 : 0];
    EXPECT_LE(result.cost_m, kSums * 1.05 * brute.to_goal);
  }
  EXPECT_GT(compared[0], 12);
  EXPECT_GT(compared[1], 6);
}

/// A U of walls, open to -x, with the start inside and the goal behind its back.
std::vector<Obstacle> uTrap()
{
  return {Box(Vec(2.0, -2.0, -10), Vec(2.2, 2.0, 10)), Box(Vec(-2.0, 2.0, -10), Vec(2.2, 2.2, 10)),
          Box(Vec(-2.0, -2.2, -10), Vec(2.2, -2.0, 10))};
}

TEST(GridSearch, LeavesAUTrap)
{
  const AnalyticField field(uTrap());
  const Vec start(1.2, 0, 1), goal(4, 0, 1);
  const Box box(Vec(-5, -5, 0), Vec(5, 5, 2));
  // The taut string round one arm at 0.5 m: two tangents (3.740 and 2.798), 0.2 + 4.2 along the
  // walls' ends and back, and 216.7 degrees of arcs.
  constexpr double kTaut = 3.740 + 0.2 + 4.2 + 2.798 + 0.5 * 3.782;
  for (const double weight : {0.0, 2.0})
  {
    GridSearchConfig config;
    config.proximity_weight = weight;
    const SearchResult result = findPath(field, start, goal, box, config);
    ASSERT_EQ(result.status, SearchStatus::Found);
    expectValidPath(field, result, start, goal, box, 0.5);
    EXPECT_LT(result.path.row(0).minCoeff(), -2.0);
    EXPECT_GE(result.length_m, kTaut - 0.01);
    EXPECT_TRUE(weight > 0.0 || result.length_m <= 1.1 * kTaut) << result.length_m;
  }
}

TEST(GridSearch, ReportsAPocketAndTheNearestPointThatCanBeReached)
{
  // The trap closed by a fourth wall around the goal.
  std::vector<Obstacle> walls = uTrap();
  walls.push_back(Box(Vec(-2.2, -2.2, -10), Vec(-2.0, 2.2, 10)));
  const AnalyticField field(walls);
  const Box box(Vec(-4, -4, 0.6), Vec(4, 4, 1.4));
  const Vec start(-3.5, 0.3, 1), goal(0.4, 0.2, 1);
  const GridSearchConfig config;
  const SearchResult result = findPath(field, start, goal, box, config);
  EXPECT_EQ(result.status, SearchStatus::Unreachable);
  EXPECT_EQ(result.path.cols(), 0);
  const BruteForce brute(field, start, goal, box, config);
  EXPECT_NEAR((result.nearest_L - goal).norm(), brute.nearest(start, goal), 1e-9);
  EXPECT_GE(clearanceOf(field, result.nearest_L), config.clearance_m);
}

/// Rooms that are closed all around, or only in space and not as seen from above; the start or the
/// goal in them; and walls from side to side.
TEST(GridSearch, WhatIsCutOffIsReportedWithTheNearestPointThatCanBeReached)
{
  int checked = 0;
  for (std::uint64_t seed = 0; seed < 24; ++seed)
  {
    SCOPED_TRACE(seed);
    Rng rng(seed);
    const Box box(Vec(-3, -2.4, 0), Vec(3, 2.4, 2.4));
    const Vec in(rng.uniform(-1, 1), rng.uniform(-0.4, 0.4), 1.2);
    const Vec out(in.x() > 0 ? -2.8 : 2.8, rng.uniform(-1.5, 1.5), 1.2);
    std::vector<Obstacle> obstacles = forest(rng, 3, 3.0);
    const double side = rng.uniform(0.5, 0.8), height = seed % 3 == 0 ? 0.5 : 9.0;
    if (seed % 3 == 2)
      obstacles.push_back(Box(Vec(-0.5 * out.x() - 0.1, -9, -9), Vec(-0.5 * out.x() + 0.1, 9, 9)));
    else
      for (int axis = 0; axis < 3; ++axis)
        for (const double sign : {-1.0, 1.0})
        {
          Vec half(side + 0.1, side + 0.1, height + 0.1), middle = in;
          middle[axis] += sign * (axis == 2 ? height : side);
          half[axis] = 0.1;
          obstacles.push_back(Box(middle - half, middle + half));
        }
    const InterpolatedField field((AnalyticField(obstacles)), box, 0.2);
    GridSearchConfig config;
    config.clearance_m = 0.25;
    const bool goal_inside = rng.integer(0, 1) == 1;
    const Vec start = goal_inside ? out : in, goal = goal_inside ? in : out;
    if (clearanceOf(field, start) < 0.25 || clearanceOf(field, goal) < 0.25) continue;
    const SearchResult result = findPath(field, start, goal, box, config);
    const BruteForce brute(field, start, goal, box, config);
    if (!std::isinf(brute.to_goal)) continue;  // the wall does not lie between them
    ASSERT_EQ(result.status, SearchStatus::Unreachable);
    EXPECT_EQ(result.path.cols(), 0);
    EXPECT_NEAR((result.nearest_L - goal).norm(), brute.nearest(start, goal), 1e-9);
    ++checked;
  }
  EXPECT_GT(checked, 10);
}

TEST(GridSearch, GoalInAnObstacleNamesTheNearestReachablePoint)
{
  int checked = 0;
  for (std::uint64_t seed = 0; seed < 20; ++seed)
  {
    SCOPED_TRACE(seed);
    Rng rng(seed);
    const Box box(Vec(-2, -2, 0.6), Vec(2, 2, 1.4));
    std::vector<Obstacle> obstacles = forest(rng, 8, 2.0);
    const Vec goal(rng.uniform(0.5, 1.5), rng.uniform(-1, 1), 1.0);
    obstacles.push_back(test::Sphere{goal + Vec(0.1, 0.05, 0.0), rng.uniform(0.3, 0.6)});
    const InterpolatedField field(AnalyticField(obstacles), box, 0.2);
    const Vec start(-1.9, rng.uniform(-1.8, 1.8), 1.0);
    GridSearchConfig config;
    config.clearance_m = 0.25;
    const SearchResult result = findPath(field, start, goal, box, config);
    if (result.status == SearchStatus::StartBlocked) continue;
    ASSERT_EQ(result.status, SearchStatus::GoalBlocked);
    EXPECT_EQ(result.path.cols(), 0);
    const BruteForce brute(field, start, goal, box, config);
    EXPECT_NEAR((result.nearest_L - goal).norm(), brute.nearest(start, goal), 1e-9);
    ++checked;
  }
  EXPECT_GT(checked, 8);
}

TEST(GridSearch, SolvesAMaze)
{
  // Baffles from alternate sides: the way is three times through the width of the box.
  std::vector<Obstacle> baffles;
  for (int i = 0; i < 4; ++i)
  {
    const double x = -3.0 + 2.0 * i, open = i % 2 == 0 ? 1.3 : -1.3;
    baffles.push_back(
        Box(Vec(x - 0.1, open > 0 ? -9 : open, -9), Vec(x + 0.1, open > 0 ? open : 9, 9)));
  }
  const AnalyticField field(baffles);
  const Vec start(-4, -2, 1), goal(4, -2, 1);
  const Box box(Vec(-5, -2.6, 0.5), Vec(5, 2.6, 1.5));
  const SearchResult result = findPath(field, start, goal, box, {});
  ASSERT_EQ(result.status, SearchStatus::Found);
  expectValidPath(field, result, start, goal, box, 0.5);
  EXPECT_GT(result.length_m, 5 * 2.0 * 1.8);
  EXPECT_LT(result.length_m, 30.0);
}

TEST(GridSearch, PreferenceChoosesTheWideGap)
{
  // A wall with a gap of 1.1 m straight ahead and one of 4 m off to the side.
  const AnalyticField field({Box(Vec(0, -0.55 - 1.0, -10), Vec(0.2, -0.55, 10)),
                             Box(Vec(0, 0.55, -10), Vec(0.2, 20, 10)),
                             Box(Vec(0, -20, -10), Vec(0.2, -5.55, 10))});
  const Vec start(-3, 0, 1), goal(3, 0, 1);
  const Box box(Vec(-5, -6, 0), Vec(5, 6, 2));
  GridSearchConfig config;
  config.proximity_weight = 0.0;
  const SearchResult shortest = findPath(field, start, goal, box, config);
  ASSERT_EQ(shortest.status, SearchStatus::Found);
  EXPECT_NEAR(shortest.length_m, 6.0, 1e-9);
  config.preferred_clearance_m = 1.2;
  config.proximity_weight = 5.0;
  const SearchResult roomy = findPath(field, start, goal, box, config);
  ASSERT_EQ(roomy.status, SearchStatus::Found);
  expectValidPath(field, roomy, start, goal, box, config.clearance_m);
  EXPECT_LT(roomy.path.row(1).minCoeff(), -2.0);
}

TEST(GridSearch, BlockedEndsAndLimitsAreNamed)
{
  const AnalyticField field({test::Sphere{{0, 0, 0}, 1.0}}, Box(Vec(-5, -5, -5), Vec(5, 5, 5)));
  const Box box(Vec(-4, -4, -4), Vec(4, 4, 4));
  const Vec free(-3, 0, 0), near(1.4, 0, 0), in(0, 0, 0), outside(6, 0, 0);
  EXPECT_EQ(findPath(field, near, free, box, {}).status, SearchStatus::StartBlocked);
  EXPECT_EQ(findPath(field, in, free, box, {}).status, SearchStatus::StartBlocked);
  EXPECT_EQ(findPath(field, outside, free, box, {}).status, SearchStatus::StartBlocked);
  EXPECT_EQ(findPath(field, free, near, box, {}).status, SearchStatus::GoalBlocked);
  const SearchResult beyond = findPath(field, free, outside, box, {});
  EXPECT_EQ(beyond.status, SearchStatus::GoalBlocked);
  EXPECT_NEAR(beyond.nearest_L.x(), 4.0, 0.2);
  EXPECT_EQ(findPath(field, free, Vec::Constant(NAN), box, {}).status, SearchStatus::GoalBlocked);
  EXPECT_EQ(findPath(field, free, Vec(3, 0, 0), Box(), {}).status, SearchStatus::StartBlocked);

  GridSearchConfig config;
  config.max_expansions = 10;
  const SearchResult cut = findPath(field, free, Vec(3, 0, 0), box, config);
  EXPECT_EQ(cut.status, SearchStatus::ExpansionLimit);
  EXPECT_EQ(cut.expansions, 10);
  EXPECT_EQ(cut.path.cols(), 0);
  EXPECT_LE((cut.nearest_L - Vec(3, 0, 0)).norm(), 6.0);
  config.clearance_m = -1.0;
  EXPECT_THROW((void)findPath(field, free, near, box, config), std::invalid_argument);
}

TEST(GridSearch, StartEqualToGoalIsFound)
{
  const AnalyticField field({test::Sphere{{0, 0, 0}, 1.0}});
  for (const double x : {5.0, 1.6})
  {
    const SearchResult result =
        findPath(field, {x, 0, 0}, {x, 0, 0}, Box(Vec(-9, -9, -1), Vec(9, 9, 1)), {});
    ASSERT_EQ(result.status, SearchStatus::Found);
    EXPECT_EQ(result.path.cols(), 2);
    EXPECT_EQ(result.length_m, 0.0);
  }
}

TEST(GridSearch, SameInputSameAnswer)
{
  for (std::uint64_t seed = 0; seed < 10; ++seed)
  {
    SCOPED_TRACE(seed);
    Rng rng(seed);
    const Box box(Vec(-5, -5, 0), Vec(5, 5, 2));
    const InterpolatedField field(AnalyticField(forest(rng, 25, 5.0)), box, 0.2);
    const Vec start(-4.5, 0, 1), goal(4.5, 0, 1);
    GridSearchConfig config;
    config.clearance_m = 0.3;
    const SearchResult a = findPath(field, start, goal, box, config);
    const SearchResult b = findPath(field, start, goal, box, config);
    EXPECT_EQ(a.status, b.status);
    EXPECT_EQ(a.expansions, b.expansions);
    EXPECT_EQ(a.path, b.path);
  }
}

/// Memory is kept between calls; what was searched before, and elsewhere, must not show.
TEST(GridSearch, SameAnswerWhateverWasSearchedBeforeAndInEveryThread)
{
  const auto ask = [](std::uint64_t seed)
  {
    Rng rng(seed);
    const double side = rng.uniform(2.5, 5.0);
    const InterpolatedField field(AnalyticField(forest(rng, 20, side)),
                                  Box(Vec(-side, -side, 0), Vec(side, side, 2)), 0.2);
    GridSearchConfig config;
    config.clearance_m = 0.3;
    return findPath(field, {-0.9 * side, 0, 1}, {0.9 * side, 0, 1}, field.bounds(), config).path;
  };
  constexpr std::uint64_t kSeeds = 12;
  std::vector<Eigen::Matrix3Xd> fresh(kSeeds);
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed)
    std::jthread([&] { fresh[seed] = ask(seed); }).join();
  const auto compare = [&]
  {
    for (std::uint64_t seed = kSeeds; seed-- > 0;) EXPECT_EQ(ask(seed), fresh[seed]) << seed;
  };
  std::jthread other(compare);
  compare();
}

TEST(SegmentClear, AgreesWithDenseSampling)
{
  int clear = 0, blocked = 0;
  for (std::uint64_t seed = 0; seed < 300; ++seed)
  {
    SCOPED_TRACE(seed);
    Rng rng(seed);
    std::vector<Obstacle> obstacles = forest(rng, 4, 3.0);
    obstacles.push_back(test::Sphere{rng.uniform3(-3, 3), rng.uniform(0.1, 1.0)});
    const AnalyticField field(obstacles);
    const Vec a = rng.uniform3(-4, 4), b = rng.uniform3(-4, 4);
    const double least = sampledClearance(field, a, b, 1e-3);
    for (const double clearance : {0.0, 0.3, least - 2e-3, least + 1e-3})
    {
      if (std::abs(clearance - least) < 1e-3 - 1e-9 || clearance < 0.0) continue;
      const bool expected = least >= clearance;
      ASSERT_EQ(segmentClear(field, a, b, clearance), expected);
      ++(expected ? clear : blocked);
    }
  }
  EXPECT_GT(clear, 150);
  EXPECT_GT(blocked, 150);
}

TEST(SegmentClear, LeavingTheFieldIsNotClear)
{
  const AnalyticField field({}, Box(Vec(-1, -1, -1), Vec(1, 1, 1)));
  EXPECT_TRUE(segmentClear(field, {-1, 0, 0}, {1, 0, 0}, 0.5));
  EXPECT_FALSE(segmentClear(field, {-1, 0, 0}, {1.1, 0, 0}, 0.5));
  EXPECT_FALSE(segmentClear(field, {0, 0, 0}, {NAN, 0, 0}, 0.5));
  EXPECT_TRUE(segmentClear(field, {0, 0, 0}, {0, 0, 0}, 0.5));
}

}  // namespace
}  // namespace slalom::search
