// SPDX-License-Identifier: BSD-3-Clause
#include "SearchProblems.h"

#include <cmath>

#include "AnalyticField.h"
#include "TextbookAStar.h"
#include "slalom/core/Rng.h"
#include "slalom/mapping/EdtSnapshot.h"

namespace slalom::bench
{
namespace
{
using core::Rng;
using Box = Eigen::AlignedBox3d;
using Vec = Eigen::Vector3d;
using Obstacles = std::vector<test::Obstacle>;

constexpr double kHalfSide = 8.0, kHeight = 8.0, kVoxel = 0.2;

std::shared_ptr<const core::DistanceField> mapOf(const Obstacles& obstacles)
{
  const test::AnalyticField exact(obstacles);
  const Eigen::Vector3i size(80, 80, 40);
  const Vec origin(-kHalfSide, -kHalfSide, 0.0);
  std::vector<core::Occupancy> cells;
  for (int k = 0; k < size.z(); ++k)
    for (int j = 0; j < size.y(); ++j)
      for (int i = 0; i < size.x(); ++i)
        cells.push_back(exact.occupancy(origin + kVoxel * Vec(i + 0.5, j + 0.5, k + 0.5)));
  return mapping::EdtSnapshot::fromOccupancy(origin, size, kVoxel, cells, 3.0);
}

SearchProblem problem(std::shared_ptr<const core::DistanceField> field, const Vec& start,
                      const Vec& goal)
{
  Box box(start.cwiseMin(goal), start.cwiseMax(goal));
  box.min() -= Vec(3.0, 3.0, 0.5);
  box.max() += Vec(3.0, 3.0, 0.5);
  return {std::move(field), start, goal, box};
}

bool clear(const SearchProblem& p, const Vec& at)
{
  return p.field->distance(at, core::UnknownAs::Free).value_or(-1.0) >=
         search::GridSearchConfig().clearance_m;
}

/// Both ends free and no straight way, but a way.
bool worthAsking(const SearchProblem& p)
{
  const search::GridSearchConfig config;
  return clear(p, p.start_L) && clear(p, p.goal_L) &&
         !search::segmentClear(*p.field, p.start_L, p.goal_L, config.clearance_m) &&
         textbookAStar(*p.field, p.start_L, p.goal_L, p.box_L, config).found;
}

Obstacles trunks(Rng& rng, double per_m2, double least, double most)
{
  Obstacles obstacles;
  for (int i = 0; i < 4.0 * kHalfSide * kHalfSide * per_m2; ++i)
    obstacles.push_back(test::VerticalCylinder{
        {rng.uniform(-kHalfSide, kHalfSide), rng.uniform(-kHalfSide, kHalfSide)},
        rng.uniform(least, most)});
  return obstacles;
}

/// Ends 2 to 8 m apart, anywhere in the map.
SearchProblem ask(Rng& rng, std::shared_ptr<const core::DistanceField> field)
{
  const Vec middle(rng.uniform(-3, 3), rng.uniform(-3, 3), rng.uniform(1.0, 2.0));
  const double heading = rng.uniform(0, 6.283), length = rng.uniform(2.0, 8.0);
  const Vec half =
      0.5 * Vec(length * std::cos(heading), length * std::sin(heading), rng.uniform(-0.4, 0.4));
  return problem(std::move(field), middle - half, middle + half);
}

template <class Make>
std::vector<SearchProblem> askUntil(std::size_t count, std::uint64_t seed, Make&& make)
{
  std::vector<SearchProblem> problems;
  Rng rng(seed);
  while (problems.size() < count)
  {
    const auto field = mapOf(make(rng));
    for (int i = 0; i < 40 && problems.size() < count; ++i)
      if (SearchProblem p = ask(rng, field); worthAsking(p)) problems.push_back(std::move(p));
  }
  return problems;
}
}  // namespace

std::vector<SearchProblem> forests(double trees_per_m2, std::size_t count)
{
  return askUntil(count, 1, [&](Rng& rng) { return trunks(rng, trees_per_m2, 0.15, 0.35); });
}

std::vector<SearchProblem> crowns(double trees_per_m2, std::size_t count)
{
  return askUntil(count, 2,
                  [&](Rng& rng)
                  {
                    Obstacles obstacles;
                    for (int i = 0; i < 4.0 * kHalfSide * kHalfSide * trees_per_m2; ++i)
                    {
                      const Eigen::Vector2d at(rng.uniform(-kHalfSide, kHalfSide),
                                               rng.uniform(-kHalfSide, kHalfSide));
                      const double radius = rng.uniform(0.5, 0.9);
                      obstacles.push_back(test::VerticalCylinder{at, rng.uniform(0.1, 0.2)});
                      obstacles.push_back(
                          test::Sphere{{at.x(), at.y(), rng.uniform(1.4, 2.4) + radius}, radius});
                    }
                    return obstacles;
                  });
}

std::vector<SearchProblem> uTraps(std::size_t count)
{
  std::vector<SearchProblem> problems;
  for (std::uint64_t seed = 0; problems.size() < count; ++seed)
  {
    Rng rng(seed);
    const double depth = rng.uniform(2.0, 4.0), half = rng.uniform(1.4, 2.0);
    const auto field = mapOf({Box(Vec(2.0, -half - 0.2, -1), Vec(2.3, half + 0.2, 9)),
                              Box(Vec(2.0 - depth, half, -1), Vec(2.3, half + 0.25, 9)),
                              Box(Vec(2.0 - depth, -half - 0.25, -1), Vec(2.3, -half, 9))});
    const SearchProblem p = problem(field, {rng.uniform(0.4, 1.2), rng.uniform(-0.5, 0.5), 1.5},
                                    {rng.uniform(3.2, 5.0), rng.uniform(-1.0, 1.0), 1.5});
    if (worthAsking(p)) problems.push_back(p);
  }
  return problems;
}

std::vector<SearchProblem> twoGaps(std::size_t count)
{
  std::vector<SearchProblem> problems;
  for (std::uint64_t seed = 0; problems.size() < count; ++seed)
  {
    Rng rng(seed);
    const double left = rng.uniform(0.6, 2.0), right = rng.uniform(0.6, 2.0);
    const auto field = mapOf({Box(Vec(0, -left, -1), Vec(0.3, right, 9)),
                              Box(Vec(0, -9, -1), Vec(0.3, -left - rng.uniform(1.4, 1.9), 9)),
                              Box(Vec(0, right + rng.uniform(1.4, 1.9), -1), Vec(0.3, 9, 9))});
    const SearchProblem p = problem(field, {rng.uniform(-4.0, -1.0), rng.uniform(-1.0, 1.0), 1.5},
                                    {rng.uniform(1.3, 4.0), rng.uniform(-1.0, 1.0), 1.5});
    if (worthAsking(p)) problems.push_back(p);
  }
  return problems;
}

std::vector<SearchProblem> unreachable(std::size_t count)
{
  std::vector<SearchProblem> problems;
  for (std::uint64_t seed = 0; problems.size() < count; ++seed)
  {
    Rng rng(seed);
    Obstacles obstacles = trunks(rng, 0.2, 0.15, 0.35);
    const double side = rng.uniform(1.2, 2.5);
    const Vec closed(rng.uniform(-4, 4), rng.uniform(-4, 4), 1.5);
    for (const double sign : {-1.0, 1.0})
    {
      const Vec x(sign * side, 0, 0), y(0, sign * side, 0);
      obstacles.push_back(Box(closed + x - Vec(0.15, side, 5), closed + x + Vec(0.15, side, 9)));
      obstacles.push_back(Box(closed + y - Vec(side, 0.15, 5), closed + y + Vec(side, 0.15, 9)));
    }
    const double heading = rng.uniform(0, 6.283), length = rng.uniform(side + 0.8, 8.0);
    const Vec other = closed + length * Vec(std::cos(heading), std::sin(heading), 0.0);
    const SearchProblem p = problems.size() % 2 == 0 ? problem(mapOf(obstacles), other, closed)
                                                     : problem(mapOf(obstacles), closed, other);
    if (clear(p, p.start_L) && clear(p, p.goal_L)) problems.push_back(p);
  }
  return problems;
}

std::vector<SearchProblem> tall(std::vector<SearchProblem> problems)
{
  for (SearchProblem& p : problems)
  {
    p.box_L.min().z() = 0.3;
    p.box_L.max().z() = kHeight;
  }
  return problems;
}
}  // namespace slalom::bench
