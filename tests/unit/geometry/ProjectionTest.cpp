// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <limits>
#include <optional>

#include "slalom/core/Rng.h"
#include "slalom/geometry/ConvexDecomposition.h"

namespace slalom::geometry
{
namespace
{
using core::HalfSpaces;
using core::Rng;

/// Nearest feasible point among the projections onto every set of at most three planes.
std::optional<Eigen::Vector3d> enumerated(const Eigen::Vector3d& x, const HalfSpaces& set)
{
  const int m = static_cast<int>(set.rows());
  std::optional<Eigen::Vector3d> best;
  const auto consider = [&](const std::vector<int>& rows)
  {
    Eigen::MatrixXd a(rows.size(), 3);
    Eigen::VectorXd r(rows.size());
    for (std::size_t k = 0; k < rows.size(); ++k)
    {
      a.row(static_cast<Eigen::Index>(k)) = set.A.row(rows[k]);
      r[static_cast<Eigen::Index>(k)] = set.A.row(rows[k]).dot(x) - set.b[rows[k]];
    }
    const Eigen::Vector3d p = rows.empty() ? x : x - a.completeOrthogonalDecomposition().solve(r);
    if (!set.contains(p, 1e-7)) return;
    if (!best || (p - x).norm() < (*best - x).norm()) best = p;
  };
  consider({});
  for (int i = 0; i < m; ++i)
  {
    consider({i});
    for (int j = i + 1; j < m; ++j)
    {
      consider({i, j});
      for (int k = j + 1; k < m; ++k) consider({i, j, k});
    }
  }
  return best;
}

HalfSpaces randomSet(Rng& rng, int rows, double lowest_offset)
{
  HalfSpaces set;
  set.A.resize(rows, 3);
  set.b.resize(rows);
  for (int i = 0; i < rows; ++i)
  {
    set.A.row(i) = rng.direction().transpose();
    set.b[i] = rng.uniform(lowest_offset, 2.0);
  }
  return set;
}

TEST(Projection, MatchesTheEnumerationOfActiveSets)
{
  int projected = 0, empty = 0;
  for (std::uint64_t seed = 0; seed < 2000; ++seed)
  {
    SCOPED_TRACE(seed);
    Rng rng(seed);
    const HalfSpaces set = randomSet(rng, rng.integer(1, 14), -0.6);
    const Eigen::Vector3d x = rng.uniform3(-5.0, 5.0);
    const auto expected = enumerated(x, set);
    const auto found = project(x, set);
    ASSERT_EQ(found.has_value(), expected.has_value());
    if (!found)
    {
      ++empty;
      continue;
    }
    ++projected;
    EXPECT_LE(set.violation(*found), 1e-9);
    EXPECT_NEAR((*found - x).norm(), (*expected - x).norm(), 1e-6);
    EXPECT_LT((*found - *expected).norm(), 1e-5);
  }
  EXPECT_GT(projected, 500);
  EXPECT_GT(empty, 100);
}

// x - p must not point into the set from p: (x - p).(q - p) <= 0 for every q of the set.
TEST(Projection, SatisfiesTheVariationalInequality)
{
  for (std::uint64_t seed = 0; seed < 2000; ++seed)
  {
    SCOPED_TRACE(seed);
    Rng rng(seed);
    const HalfSpaces set = randomSet(rng, rng.integer(4, 40), 0.05);  // holds the origin
    const Eigen::Vector3d x = rng.uniform3(-20.0, 20.0);
    const auto p = project(x, set);
    ASSERT_TRUE(p);
    EXPECT_LE(set.violation(*p), 1e-9);
    for (int k = 0; k < 20; ++k)
    {
      const Eigen::Vector3d direction = rng.direction();
      const Eigen::VectorXd rate = set.A * direction;
      double reach = 10.0;
      for (Eigen::Index i = 0; i < set.rows(); ++i)
        if (rate[i] > 0.0) reach = std::min(reach, set.b[i] / rate[i]);
      const Eigen::Vector3d q = rng.uniform() * reach * direction;
      EXPECT_LE((x - *p).dot(q - *p), 1e-7);
    }
  }
}

TEST(Projection, LeavesInnerPointsAloneAndIsIdempotent)
{
  for (std::uint64_t seed = 0; seed < 500; ++seed)
  {
    SCOPED_TRACE(seed);
    Rng rng(seed);
    const HalfSpaces set = randomSet(rng, rng.integer(4, 20), 0.2);
    const Eigen::Vector3d inner = 0.19 * rng.direction();
    EXPECT_EQ(*project(inner, set), inner);
    const auto p = project(rng.uniform3(-9.0, 9.0), set);
    ASSERT_TRUE(p);
    EXPECT_LT((*project(*p, set) - *p).norm(), 1e-9);
  }
}

TEST(Projection, CopesWithRepeatedAndNearlyParallelPlanes)
{
  for (std::uint64_t seed = 0; seed < 2000; ++seed)
  {
    SCOPED_TRACE(seed);
    Rng rng(seed);
    HalfSpaces set = randomSet(rng, 12, 0.1);
    const double tilt = std::pow(10.0, rng.uniform(-12.0, -3.0));
    for (int i = 6; i < 12; ++i)
    {
      set.A.row(i) = (set.A.row(i - 6).transpose() + tilt * rng.direction()).normalized();
      set.b[i] = set.b[i - 6] + rng.uniform(-1.0, 1.0) * tilt;
    }
    const Eigen::Vector3d x = rng.uniform3(-5.0, 5.0);
    const auto p = project(x, set);
    ASSERT_TRUE(p);
    EXPECT_LE(set.violation(*p), 1e-8);
    HalfSpaces half = set;
    half.A = set.A.topRows(6).eval();
    half.b = set.b.head(6).eval();
    // Tilting the copies moves the distance by no more than they were tilted.
    EXPECT_NEAR((*p - x).norm(), (*project(x, half) - x).norm(), 1e4 * tilt + 1e-7);
  }
}

TEST(Projection, ReportsEmptySets)
{
  HalfSpaces slab;
  slab.A.resize(2, 3);
  slab.b.resize(2);
  slab.A << 1, 0, 0, -1, 0, 0;
  slab.b << 1.0, -1.1;  // x <= 1 and x >= 1.1
  EXPECT_FALSE(project(Eigen::Vector3d(5, 2, 3), slab));
  EXPECT_FALSE(project(Eigen::Vector3d(1.05, 2, 3), slab));
  slab.b[1] = -1.0;  // x = 1
  ASSERT_TRUE(project(Eigen::Vector3d(5, 2, 3), slab));
  EXPECT_LT((*project(Eigen::Vector3d(5, 2, 3), slab) - Eigen::Vector3d(1, 2, 3)).norm(), 1e-9);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(project(Eigen::Vector3d(nan, 0, 0), slab));
  EXPECT_EQ(*project(Eigen::Vector3d(1, 2, 3), HalfSpaces{}), Eigen::Vector3d(1, 2, 3));
}

}  // namespace
}  // namespace slalom::geometry
