// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <stdexcept>
#include <string>

#include "SearchChecks.h"
#include "slalom/core/Rng.h"
#include "slalom/search/DistinctPaths.h"

namespace slalom::search
{
namespace
{
using core::Rng;
using test::AnalyticField;
using test::InterpolatedField;
using test::Obstacle;
using Box = Eigen::AlignedBox3d;
using Vec = Eigen::Vector3d;
using Paths = std::vector<SearchResult>;

/// What every answer promises.
void expectLaws(const core::DistanceField& field, const Paths& paths, const Vec& start,
                const Vec& goal, const Box& box, const GridSearchConfig& config)
{
  ASSERT_GE(paths.size(), 1u);
  ASSERT_LE(paths.size(), 3u);
  const SearchResult first = findPath(field, start, goal, box, config);
  EXPECT_EQ(paths[0].status, first.status);
  EXPECT_EQ(paths[0].path, first.path);
  if (first.status != SearchStatus::Found)
  {
    EXPECT_EQ(paths.size(), 1u);
    return;
  }
  int expansions = 0;
  for (std::size_t i = 0; i < paths.size(); ++i)
  {
    expectValidPath(field, paths[i], start, goal, box, config.clearance_m);
    EXPECT_LE(paths[i].cost_m, config.max_detour * first.cost_m);
    EXPECT_GE(paths[i].cost_m, paths[i].length_m - 1e-9);
    if (i >= 2)
    {
      EXPECT_GE(paths[i].cost_m, paths[i - 1].cost_m);
    }
    // Each is near-optimal only, so the first need not be the cheapest.
    EXPECT_GE(paths[i].cost_m, first.cost_m / 1.1);
    for (std::size_t j = 0; j < i; ++j)
      EXPECT_FALSE(deformable(field, paths[j].path, paths[i].path, config.clearance_m));
    expansions += paths[i].expansions;
  }
  EXPECT_LE(expansions, config.max_expansions);
}

Box narrow(const Vec& start, const Vec& goal)
{
  Box box(start.cwiseMin(goal), start.cwiseMax(goal));
  box.min() -= Vec(3.0, 3.0, 0.5);
  box.max() += Vec(3.0, 3.0, 0.5);
  return box;
}

Box wall(double from, double to)
{
  return Box(Vec(-0.15, from, -10), Vec(0.15, to, 10));
}

/// Where a path crosses x = 0.
std::set<int> crossings(const Paths& paths, const std::vector<double>& limits, int axis = 1)
{
  std::set<int> intervals;
  for (const SearchResult& result : paths)
    for (Eigen::Index i = 1; i < result.path.cols(); ++i)
    {
      const Vec a = result.path.col(i - 1), b = result.path.col(i);
      if (a.x() > 0.0 || b.x() <= 0.0) continue;
      const double y = (a + (b - a) * (-a.x() / (b.x() - a.x())))[axis];
      intervals.insert(
          static_cast<int>(std::upper_bound(limits.begin(), limits.end(), y) - limits.begin()));
    }
  return intervals;
}

struct Situation
{
  std::string name;
  std::vector<Obstacle> obstacles;
  double reach;                ///< of the box in y
  std::vector<double> limits;  ///< obstacles at x = 0
  std::set<int> intervals;     ///< between them, that paths must use
};

TEST(DistinctPaths, EveryClassOfAKnownSituationIsFoundAndNoOther)
{
  const std::vector<Situation> situations = {
      {"free", {}, 3, {}, {0}},
      {"pillar", {test::VerticalCylinder{{0, 0}, 0.4}}, 3, {0}, {0, 1}},
      {"two gaps", {wall(-9, -2), wall(-0.4, 0.4), wall(2, 9)}, 3, {0}, {0, 1}},
      {"three gaps",
       {wall(-9, -3.2), wall(-1.4, -0.8), wall(0.8, 1.4), wall(3.2, 9)},
       4,
       {-1.1, 1.1},
       {0, 1, 2}},
      {"a gap too narrow", {wall(-9, -2), wall(-0.4, 0.4), wall(1.2, 9)}, 3, {0}, {0}},
      {"corridor",
       {Box(Vec(-9, 0.9, -9), Vec(9, 1.2, 9)), Box(Vec(-9, -1.2, -9), Vec(9, -0.9, 9))},
       3,
       {},
       {0}},
      {"bent corridor",
       {Box(Vec(-9, 0.9, -9), Vec(0.5, 1.2, 9)), Box(Vec(-9, -1.2, -9), Vec(9, -0.9, 9)),
        test::VerticalCylinder{{0, 0.9}, 0.5}},
       0.9,
       {},
       {0}}};
  for (const Situation& situation : situations)
    for (const double resolution : {0.1, 0.2})
      for (const double weight : {0.0, 2.0})
      {
        SCOPED_TRACE(situation.name + " at " + std::to_string(resolution));
        const Vec start(-2.5, 0.1, 1.5), goal(2.3, 0.05, 1.6);
        Box box = narrow(start, goal);
        box.min().y() = -situation.reach;
        box.max().y() = situation.reach;
        const InterpolatedField field(AnalyticField(situation.obstacles),
                                      Box(Vec(-6, -5, 0), Vec(6, 5, 3)), resolution);
        GridSearchConfig config;
        config.proximity_weight = weight;
        const Paths paths = findDistinctPaths(field, start, goal, box, config, 3);
        expectLaws(field, paths, start, goal, box, config);
        EXPECT_EQ(crossings(paths, situation.limits), situation.intervals);
        EXPECT_EQ(paths.size(), situation.intervals.size());
      }
}

TEST(DistinctPaths, BothSidesOfASphereAndOverAndUnderABeam)
{
  const Vec start(-3, 0.05, 4), goal(3, 0, 4.1);
  const Box box(Vec(-5, -4, 0.5), Vec(5, 4, 7.5));
  const GridSearchConfig config;

  const AnalyticField sphere({test::Sphere{{0, 0, 4}, 1.0}});
  const Paths around = findDistinctPaths(sphere, start, goal, box, config, 3);
  expectLaws(sphere, around, start, goal, box, config);
  ASSERT_GE(around.size(), 2u);
  // The first two pass it more than a right angle apart.
  std::vector<Vec> passing;
  for (const SearchResult& result : around)
    for (Eigen::Index i = 1; i < result.path.cols(); ++i)
    {
      const Vec a = result.path.col(i - 1), b = result.path.col(i);
      if (a.x() <= 0.0 && b.x() > 0.0)
        passing.push_back(a + (b - a) * (-a.x() / (b.x() - a.x())) - Vec(0, 0, 4));
    }
  ASSERT_GE(passing.size(), 2u);
  EXPECT_LT(passing[0].dot(passing[1]), 0.0);

  const AnalyticField beam({Box(Vec(-0.2, -20, 3.8), Vec(0.2, 20, 4.2))});
  const Paths past = findDistinctPaths(beam, start, goal, box, config, 3);
  expectLaws(beam, past, start, goal, box, config);
  EXPECT_EQ(past.size(), 2u);
  EXPECT_EQ(crossings(past, {4.0}, 2), (std::set<int>{0, 1}));
}

TEST(DistinctPaths, LawsHoldInRandomForests)
{
  int found = 0, several = 0, three = 0;
  for (std::uint64_t seed = 0; seed < 150; ++seed)
  {
    SCOPED_TRACE(seed);
    Rng rng(seed);
    const InterpolatedField field(AnalyticField(forest(rng, 30, 5.0)),
                                  Box(Vec(-6, -6, 0), Vec(6, 6, 3)), 0.2);
    const Vec start(rng.uniform(-4.5, -1), rng.uniform(-3, 3), rng.uniform(1, 2));
    const Vec goal(rng.uniform(1, 4.5), rng.uniform(-3, 3), rng.uniform(1, 2));
    GridSearchConfig config;
    config.clearance_m = rng.uniform(0.25, 0.5);
    config.max_detour = rng.uniform(1.2, 2.0);
    const Box box = narrow(start, goal);
    const Paths paths = findDistinctPaths(field, start, goal, box, config, 3);
    expectLaws(field, paths, start, goal, box, config);
    const Paths again = findDistinctPaths(field, start, goal, box, config, 3);
    ASSERT_EQ(paths.size(), again.size());
    for (std::size_t i = 0; i < paths.size(); ++i) EXPECT_EQ(paths[i].path, again[i].path);
    found += paths[0].status == SearchStatus::Found ? 1 : 0;
    several += paths.size() > 1 ? 1 : 0;
    three += paths.size() > 2 ? 1 : 0;
  }
  EXPECT_GT(found, 50);
  EXPECT_GT(several, 0.7 * found);
  EXPECT_GT(three, 0.5 * found);
}

/// One pillar: the other side's way, had by a wall from the pillar through the first path, is
/// there exactly if it is cheap enough.
TEST(DistinctPaths, TheOtherSideOfAPillarIsFoundIfItIsCheapEnough)
{
  int with = 0, without = 0;
  for (std::uint64_t seed = 0; seed < 60; ++seed)
  {
    SCOPED_TRACE(seed);
    Rng rng(seed);
    const Vec start(rng.uniform(-3, -1.2), 0, 1.5), goal(rng.uniform(1.2, 3), 0, 1.5);
    const double radius = rng.uniform(0.1, 0.6), y = rng.uniform(-1.0, 1.0);
    const std::vector<Obstacle> pillar = {test::VerticalCylinder{{0, y}, radius}};
    const AnalyticField field(pillar);
    GridSearchConfig config;
    config.max_detour = rng.uniform(1.05, 1.6);
    const Box box = narrow(start, goal);
    const Paths paths = findDistinctPaths(field, start, goal, box, config, 3);
    expectLaws(field, paths, start, goal, box, config);
    const bool first_is_left = crossings({paths[0]}, {y}).count(1) == 1;
    const AnalyticField closed({pillar[0], first_is_left ? wall(y, 9) : wall(-9, y)});
    const SearchResult other = findPath(closed, start, goal, box, config);
    ASSERT_EQ(other.status, SearchStatus::Found);
    // Both costs are near-optimal only.
    const double ratio = other.cost_m / paths[0].cost_m / config.max_detour;
    if (ratio > 0.95 && ratio < 1.05) continue;
    ASSERT_EQ(paths.size(), ratio < 1.0 ? 2u : 1u);
    ++(ratio < 1.0 ? with : without);
    if (ratio < 1.0)
    {
      EXPECT_LE(paths[1].cost_m, 1.06 * other.cost_m);
    }
  }
  EXPECT_GT(with, 10);
  EXPECT_GT(without, 5);
}

TEST(DistinctPaths, LimitsAndFailuresAreThoseOfFindPath)
{
  const AnalyticField field({test::Sphere{{0, 0, 0}, 1.0}}, Box(Vec(-5, -5, -5), Vec(5, 5, 5)));
  const Box box(Vec(-4, -4, -4), Vec(4, 4, 4));
  const Vec start(-3, 0, 0), goal(3, 0, 0);
  for (const int paths : {1, 2, 3})
    EXPECT_LE(findDistinctPaths(field, start, goal, box, {}, paths).size(), std::size_t(paths));
  const Paths blocked = findDistinctPaths(field, start, {0, 0, 0}, box, {}, 3);
  ASSERT_EQ(blocked.size(), 1u);
  EXPECT_EQ(blocked[0].status, SearchStatus::GoalBlocked);
  GridSearchConfig config;
  config.max_expansions = 10;
  const Paths cut = findDistinctPaths(field, start, goal, box, config, 3);
  ASSERT_EQ(cut.size(), 1u);
  EXPECT_EQ(cut[0].status, SearchStatus::ExpansionLimit);
  for (const int paths : {0, 4, -1})
    EXPECT_THROW((void)findDistinctPaths(field, start, goal, box, {}, paths),
                 std::invalid_argument);
  config.max_detour = -1.0;
  EXPECT_THROW((void)findDistinctPaths(field, start, goal, box, config, 3), std::invalid_argument);
  EXPECT_EQ(findDistinctPaths(field, start, start, box, {}, 3).size(), 1u);
}

TEST(Deformable, PathsAcrossAPillarAreNotAndBesideItAre)
{
  const AnalyticField field({test::VerticalCylinder{{0, 0}, 0.4}});
  Eigen::Matrix3Xd left(3, 3), wide(3, 4), right(3, 3), straight(3, 2);
  left << -3, 0, 3, 0, 1.2, 0, 1, 1, 1;
  wide << -3, -1, 1, 3, 0, 2.5, 2, 0, 1, 1.2, 1, 1;
  right << -3, 0, 3, 0, -1.2, 0, 1, 1, 1;
  straight << 5, 6, 0, 0, 1, 1;
  EXPECT_TRUE(deformable(field, left, wide, 0.5));
  EXPECT_TRUE(deformable(field, wide, left, 0.5));
  EXPECT_TRUE(deformable(field, left, left, 0.5));
  EXPECT_FALSE(deformable(field, left, right, 0.5));
  EXPECT_FALSE(deformable(field, right, wide, 0.5));
  EXPECT_TRUE(deformable(field, straight, straight, 0.5));
  EXPECT_TRUE(deformable(field, straight.leftCols(1), straight.leftCols(1), 0.5));
}

}  // namespace
}  // namespace slalom::search
