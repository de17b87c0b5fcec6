// SPDX-License-Identifier: BSD-3-Clause
// Laws of the distance snapshot, checked against brute force over all cells.
#include <gtest/gtest.h>

#include <cmath>

#include "slalom/core/Rng.h"
#include "slalom/mapping/EdtSnapshot.h"

namespace
{
using slalom::core::Occupancy;
using slalom::core::Rng;
using slalom::core::UnknownAs;
using slalom::mapping::EdtSnapshot;
using Vec3 = Eigen::Vector3d;

constexpr UnknownAs kBoth[] = {UnknownAs::Free, UnknownAs::Occupied};

struct RandomGrid
{
  Vec3 origin = Vec3::Zero();
  Eigen::Vector3i size = Eigen::Vector3i::Ones();
  double resolution = 0.2;
  double max_distance = 1.0;
  std::vector<Occupancy> cells;
  std::shared_ptr<const EdtSnapshot> snapshot;

  Occupancy at(int x, int y, int z) const
  {
    return cells[(static_cast<std::size_t>(z) * size.y() + y) * size.x() + x];
  }
  Vec3 centre(int x, int y, int z) const
  {
    return origin + resolution * Vec3(x + 0.5, y + 0.5, z + 0.5);
  }
  // Everything outside the grid is unknown.
  bool obstacle(int x, int y, int z, UnknownAs unknown) const
  {
    const bool inside = x >= 0 && y >= 0 && z >= 0 && x < size.x() && y < size.y() && z < size.z();
    const Occupancy value = inside ? at(x, y, z) : Occupancy::Unknown;
    return value == Occupancy::Occupied ||
           (value == Occupancy::Unknown && unknown == UnknownAs::Occupied);
  }
  template <class Visit>
  void each(int margin, Visit&& visit) const
  {
    for (int z = -margin; z < size.z() + margin; ++z)
      for (int y = -margin; y < size.y() + margin; ++y)
        for (int x = -margin; x < size.x() + margin; ++x) visit(x, y, z);
  }
};

// Boxes of unknown and occupied cells plus speckle, from nearly empty to nearly full.
RandomGrid randomGrid(Rng& rng, int edge, double max_distance)
{
  RandomGrid grid;
  grid.origin = rng.uniform3(-5.0, 5.0);
  grid.resolution = rng.uniform(0.05, 0.5);
  grid.max_distance = max_distance * grid.resolution;
  grid.size = Eigen::Vector3i(rng.integer(2, edge), rng.integer(2, edge), rng.integer(2, edge));
  grid.cells.assign(static_cast<std::size_t>(grid.size.prod()), Occupancy::Free);
  const auto paint = [&](Occupancy value, int boxes)
  {
    for (int i = 0; i < boxes; ++i)
    {
      Eigen::Vector3i a, b;
      for (int axis = 0; axis < 3; ++axis)
      {
        a[axis] = rng.integer(0, grid.size[axis] - 1);
        b[axis] = std::min(grid.size[axis] - 1, a[axis] + rng.integer(0, 8));
      }
      for (int z = a.z(); z <= b.z(); ++z)
        for (int y = a.y(); y <= b.y(); ++y)
          for (int x = a.x(); x <= b.x(); ++x)
            grid.cells[(static_cast<std::size_t>(z) * grid.size.y() + y) * grid.size.x() + x] =
                value;
    }
  };
  paint(Occupancy::Unknown, rng.integer(0, 4));
  paint(Occupancy::Occupied, rng.integer(0, 4));
  const double speckle = rng.uniform() < 0.5 ? 0.0 : rng.uniform(0.0, 0.3);
  for (Occupancy& cell : grid.cells)
    if (rng.uniform() < speckle)
      cell = rng.uniform() < 0.5 ? Occupancy::Unknown : Occupancy::Occupied;
  grid.snapshot = EdtSnapshot::fromOccupancy(grid.origin, grid.size, grid.resolution, grid.cells,
                                             grid.max_distance, 3.5);
  return grid;
}

// Signed distance from a cell centre to the obstacle surface, by looking at every other cell.
double bruteForce(const RandomGrid& grid, int x, int y, int z, UnknownAs unknown)
{
  const bool inside = grid.obstacle(x, y, z, unknown);
  const int margin = 1;  // the nearest cell outside the grid is one of its direct neighbours
  double nearest = std::numeric_limits<double>::infinity();
  grid.each(margin,
            [&](int i, int j, int k)
            {
              if (grid.obstacle(i, j, k, unknown) != inside)
                nearest = std::min(
                    nearest, std::sqrt((i - x) * (i - x) + (j - y) * (j - y) + (k - z) * (k - z)));
            });
  const double surface = std::min(grid.max_distance, grid.resolution * (nearest - 0.5));
  return inside ? -surface : surface;
}

// True distance from p to the nearest point of any obstacle cube (0 inside one).
double distanceToCubes(const RandomGrid& grid, const Vec3& p, UnknownAs unknown)
{
  double nearest = std::numeric_limits<double>::infinity();
  const Vec3 half = Vec3::Constant(0.5 * grid.resolution);
  grid.each(1,
            [&](int x, int y, int z)
            {
              if (!grid.obstacle(x, y, z, unknown)) return;
              const Vec3 c = grid.centre(x, y, z);
              nearest =
                  std::min(nearest, Eigen::AlignedBox3d(c - half, c + half).exteriorDistance(p));
            });
  return nearest;
}

Vec3 randomPoint(Rng& rng, const Eigen::AlignedBox3d& box)
{
  Vec3 p;
  for (int axis = 0; axis < 3; ++axis) p[axis] = rng.uniform(box.min()[axis], box.max()[axis]);
  return p;
}

TEST(EdtSnapshot, CellDistancesEqualBruteForceInBothFields)
{
  for (std::uint64_t seed = 0; seed < 60; ++seed)
  {
    SCOPED_TRACE(seed);
    Rng rng(seed);
    const double saturations[] = {0.6, 1.0, 2.5, 4.0, 7.3, 15.0, 31.0, 100.0};
    const RandomGrid grid = randomGrid(rng, seed < 50 ? 14 : 35, saturations[seed % 8]);
    // Big grids are checked in a random tenth of their cells.
    const double share = seed < 50 ? 1.0 : 0.02;
    grid.each(0,
              [&](int x, int y, int z)
              {
                if (rng.uniform() > share) return;
                for (const UnknownAs unknown : kBoth)
                {
                  const auto sample = grid.snapshot->sample(grid.centre(x, y, z), unknown);
                  if (!sample)  // rounding may put the outermost centres outside
                  {
                    EXPECT_FALSE(grid.snapshot->bounds().contains(grid.centre(x, y, z)));
                    continue;
                  }
                  ASSERT_NEAR(sample->distance, bruteForce(grid, x, y, z, unknown), 1e-9)
                      << x << ' ' << y << ' ' << z << " unknown as " << static_cast<int>(unknown);
                }
              });
  }
}

TEST(EdtSnapshot, LowerBoundNeverExceedsTheTrueDistanceAndStaysNearTheSample)
{
  double worst_gap = 0.0, smallest_slack = 1e9;
  for (std::uint64_t seed = 0; seed < 120; ++seed)
  {
    SCOPED_TRACE(seed);
    Rng rng(seed);
    const RandomGrid grid = randomGrid(rng, 12, seed % 2 ? 30.0 : 4.0);
    for (int i = 0; i < 150; ++i)
    {
      const Vec3 p = randomPoint(rng, grid.snapshot->bounds());
      for (const UnknownAs unknown : kBoth)
      {
        const double truth = distanceToCubes(grid, p, unknown);
        const double bound = grid.snapshot->lowerBound(p, unknown).value();
        const double sampled = grid.snapshot->sample(p, unknown)->distance;
        ASSERT_LE(bound, truth);
        ASSERT_LE(bound, sampled);
        ASSERT_GE(bound, sampled - std::sqrt(3.0) * grid.resolution);
        worst_gap = std::max(worst_gap, (sampled - bound) / grid.resolution);
        if (truth > 0.0 && bound > 0.0)
          smallest_slack = std::min(smallest_slack, (truth - bound) / grid.resolution);
      }
    }
  }
  // The bound must also be of use: tight somewhere, and never looser than the proof says.
  EXPECT_LT(smallest_slack, 0.1);
  EXPECT_LE(worst_gap, std::sqrt(3.0) - 0.5 + 1e-6);
}

TEST(EdtSnapshot, LowerBoundHoldsOnEveryPointOfSegmentsToObstacleCorners)
{
  for (std::uint64_t seed = 200; seed < 230; ++seed)
  {
    SCOPED_TRACE(seed);
    Rng rng(seed);
    const RandomGrid grid = randomGrid(rng, 10, 20.0);
    const Vec3 a = randomPoint(rng, grid.snapshot->bounds());
    const Vec3 b = randomPoint(rng, grid.snapshot->bounds());
    for (int i = 0; i <= 100; ++i)
    {
      const Vec3 p = a + i / 100.0 * (b - a);
      for (const UnknownAs unknown : kBoth)
        ASSERT_LE(grid.snapshot->lowerBound(p, unknown).value(), distanceToCubes(grid, p, unknown));
    }
  }
}

TEST(EdtSnapshot, GradientIsTheDerivativeOfTheSample)
{
  for (std::uint64_t seed = 0; seed < 20; ++seed)
  {
    SCOPED_TRACE(seed);
    Rng rng(seed);
    const RandomGrid grid = randomGrid(rng, 16, 5.0);
    const double h = 1e-5 * grid.resolution;
    for (int i = 0; i < 100; ++i)
    {
      // Between cell centres the interpolant is smooth; keep the differences inside one cell.
      Vec3 p;
      for (int axis = 0; axis < 3; ++axis)
        p[axis] = grid.origin[axis] + grid.resolution * (0.5 + rng.integer(0, grid.size[axis] - 2) +
                                                         rng.uniform(0.01, 0.99));
      for (const UnknownAs unknown : kBoth)
      {
        const Vec3 gradient = grid.snapshot->sample(p, unknown)->gradient;
        for (int axis = 0; axis < 3; ++axis)
        {
          const Vec3 step = h * Vec3::Unit(axis);
          const double difference = (grid.snapshot->sample(p + step, unknown)->distance -
                                     grid.snapshot->sample(p - step, unknown)->distance) /
                                    (2.0 * h);
          ASSERT_NEAR(gradient[axis], difference, 1e-6);
        }
      }
    }
  }
}

TEST(EdtSnapshot, SampleIsContinuousAcrossCells)
{
  Rng rng(5);
  const RandomGrid grid = randomGrid(rng, 16, 6.0);
  for (int i = 0; i < 500; ++i)
  {
    const Vec3 p = randomPoint(rng, grid.snapshot->bounds());
    const Vec3 q = p + 1e-6 * grid.resolution * rng.direction();
    if (!grid.snapshot->bounds().contains(q)) continue;
    for (const UnknownAs unknown : kBoth)
      EXPECT_NEAR(grid.snapshot->sample(p, unknown)->distance,
                  grid.snapshot->sample(q, unknown)->distance, 4e-6 * grid.resolution);
  }
}

TEST(EdtSnapshot, OutsideBoundsThereIsNoNumber)
{
  Rng rng(11);
  const RandomGrid grid = randomGrid(rng, 10, 5.0);
  const Eigen::AlignedBox3d bounds = grid.snapshot->bounds();
  EXPECT_NEAR((bounds.min() - grid.centre(0, 0, 0)).norm(), 0.0, 1e-12);
  for (int axis = 0; axis < 3; ++axis)
    for (const double side : {-1.0, 1.0})
    {
      Vec3 p = bounds.center();
      p[axis] += side * (0.5 * bounds.sizes()[axis] + 1e-6);
      EXPECT_EQ(grid.snapshot->occupancy(p), Occupancy::Unknown);
      for (const UnknownAs unknown : kBoth)
      {
        EXPECT_FALSE(grid.snapshot->sample(p, unknown));
        EXPECT_FALSE(grid.snapshot->lowerBound(p, unknown));
        EXPECT_FALSE(grid.snapshot->distance(p, unknown));
      }
    }
  const Vec3 nan = Vec3::Constant(std::numeric_limits<double>::quiet_NaN());
  EXPECT_FALSE(grid.snapshot->sample(nan, UnknownAs::Free));
  EXPECT_EQ(grid.snapshot->occupancy(nan), Occupancy::Unknown);
}

TEST(EdtSnapshot, HullBoundOfAPointIsItsDistanceToTheCubes)
{
  int near_limit = 0, outside = 0;
  for (std::uint64_t seed = 0; seed < 120; ++seed)
  {
    SCOPED_TRACE(seed);
    Rng rng(seed);
    const RandomGrid grid = randomGrid(rng, 12, seed % 2 ? 30.0 : 4.0);
    const Eigen::AlignedBox3d bounds = grid.snapshot->bounds();
    const Vec3 margin = Vec3::Constant(2.0 * grid.resolution);
    const Eigen::AlignedBox3d around(bounds.min() - margin, bounds.max() + margin);
    for (int i = 0; i < 150; ++i)
    {
      const Vec3 p = randomPoint(rng, i % 3 ? bounds : around);
      const double limit = grid.resolution * rng.uniform(0.0, 12.0);
      for (const UnknownAs unknown : kBoth)
      {
        double truth = distanceToCubes(grid, p, unknown);
        // With unknown as an obstacle all space outside the bounds is one.
        if (unknown == UnknownAs::Occupied)
          truth = std::max(
              0.0, std::min({truth, (p - bounds.min()).minCoeff(), (bounds.max() - p).minCoeff()}));
        const double tight = grid.snapshot->hullBound(p.replicate<1, 4>(), unknown, limit);
        const double exact = std::min(limit, truth);
        ASSERT_LE(tight, exact);
        ASSERT_NEAR(tight, exact, 2e-9);
        ASSERT_LE(grid.snapshot->boundEverywhere(p, unknown), truth);
        near_limit += truth > limit;
        outside += !bounds.contains(p);
      }
    }
  }
  EXPECT_GT(near_limit, 1000);
  EXPECT_GT(outside, 1000);
}

TEST(EdtSnapshot, HullBoundHoldsOnTheHullAndLacksTheSquareOfItsSize)
{
  int useful = 0;
  for (std::uint64_t seed = 0; seed < 120; ++seed)
  {
    SCOPED_TRACE(seed);
    Rng rng(seed);
    const RandomGrid grid = randomGrid(rng, 12, seed % 2 ? 30.0 : 4.0);
    const Eigen::AlignedBox3d bounds = grid.snapshot->bounds();
    for (int i = 0; i < 20; ++i)
    {
      // An edge of up to four voxels with two points near it, as a curve's piece has.
      const double size = grid.resolution * rng.uniform(0.0, 4.0);
      slalom::core::Hull4 hull;
      hull.col(0) = randomPoint(rng, bounds);
      hull.col(3) = hull.col(0) + size * rng.direction();
      for (const int j : {1, 2})
        hull.col(j) = hull.col(0) + j / 3.0 * (hull.col(3) - hull.col(0)) + rng.normal3(0.1 * size);
      for (const UnknownAs unknown : kBoth)
      {
        const double bound = grid.snapshot->hullBound(hull, unknown, 10.0 * grid.resolution);
        double nearest = std::numeric_limits<double>::infinity();
        for (int k = 0; k < 30; ++k)
        {
          Eigen::Vector4d weights;
          for (double& weight : weights) weight = -std::log(1.0 - rng.uniform());
          if (k < 4) weights = Eigen::Vector4d::Unit(k);
          const Vec3 p = hull * weights / weights.sum();
          nearest = std::min(nearest, distanceToCubes(grid, p, unknown));
          if (unknown == UnknownAs::Occupied)
            nearest = std::min({nearest, std::max(0.0, (p - bounds.min()).minCoeff()),
                                std::max(0.0, (bounds.max() - p).minCoeff())});
        }
        ASSERT_LE(bound, nearest);
        useful += bound > 0.5 * nearest && bound < nearest && size > grid.resolution;
      }
    }
  }
  EXPECT_GT(useful, 500);
}

// Beside the middle of a wall a hull as long as the wall has its full distance, not that of a ball.
TEST(EdtSnapshot, HullBoundAlongAWallIsExact)
{
  std::vector<Occupancy> cells(40 * 40 * 10, Occupancy::Free);
  for (int z = 0; z < 10; ++z)
    for (int x = 0; x < 40; ++x)
      cells[static_cast<std::size_t>((z * 40 + 30) * 40 + x)] = Occupancy::Occupied;
  const auto wall = EdtSnapshot::fromOccupancy(Vec3::Zero(), {40, 40, 10}, 0.1, cells, 2.0);
  slalom::core::Hull4 hull;
  for (int j = 0; j < 4; ++j) hull.col(j) << 0.5 + j, 2.3, 0.5;
  EXPECT_NEAR(wall->hullBound(hull, UnknownAs::Free, 5.0), 0.7, 2e-9);
  EXPECT_NEAR(wall->hullBound(hull, UnknownAs::Free, 0.6), 0.6, 2e-9);
  hull.col(2).y() += 0.1;
  EXPECT_LE(wall->hullBound(hull, UnknownAs::Free, 5.0), 0.6);
  EXPECT_GE(wall->hullBound(hull, UnknownAs::Free, 5.0), 0.58);
}

TEST(EdtSnapshot, OccupancyAndCollectObstaclesReturnTheGivenCells)
{
  for (std::uint64_t seed = 0; seed < 20; ++seed)
  {
    SCOPED_TRACE(seed);
    Rng rng(seed);
    const RandomGrid grid = randomGrid(rng, 12, 5.0);
    const Eigen::AlignedBox3d bounds = grid.snapshot->bounds();
    Eigen::AlignedBox3d box(randomPoint(rng, bounds));
    box.extend(randomPoint(rng, bounds));
    for (const UnknownAs unknown : kBoth)
    {
      std::vector<Vec3> expected;
      grid.each(0,
                [&](int x, int y, int z)
                {
                  const Vec3 c = grid.centre(x, y, z);
                  if (bounds.contains(c))
                  {
                    EXPECT_EQ(grid.snapshot->occupancy(c), grid.at(x, y, z));
                  }
                  if (grid.obstacle(x, y, z, unknown) && box.contains(c)) expected.push_back(c);
                });
      std::vector<Vec3> collected;
      grid.snapshot->collectObstacles(box, unknown, collected);
      ASSERT_EQ(collected.size(), expected.size());
      for (std::size_t i = 0; i < expected.size(); ++i)
        EXPECT_LT((collected[i] - expected[i]).norm(), 1e-12);
    }
  }
}

TEST(EdtSnapshot, RefusesWhatCannotBeInterpolated)
{
  const std::vector<Occupancy> eight(8, Occupancy::Free);
  const Eigen::Vector3i two(2, 2, 2);
  EXPECT_NO_THROW((void)EdtSnapshot::fromOccupancy(Vec3::Zero(), two, 0.1, eight, 1.0));
  EXPECT_THROW((void)EdtSnapshot::fromOccupancy(Vec3::Zero(), {8, 1, 1}, 0.1, eight, 1.0),
               std::invalid_argument);
  EXPECT_THROW((void)EdtSnapshot::fromOccupancy(Vec3::Zero(), {2, 2, 3}, 0.1, eight, 1.0),
               std::invalid_argument);
  EXPECT_THROW((void)EdtSnapshot::fromOccupancy(Vec3::Zero(), two, 0.0, eight, 1.0),
               std::invalid_argument);
  EXPECT_THROW((void)EdtSnapshot::fromOccupancy(Vec3::Zero(), two, 0.001, eight, 1.0),
               std::invalid_argument);
  const Vec3 nan = Vec3::Constant(std::numeric_limits<double>::quiet_NaN());
  EXPECT_THROW((void)EdtSnapshot::fromOccupancy(nan, two, 0.1, eight, 1.0), std::invalid_argument);
}

}  // namespace
