// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "CloseObstacles.h"
#include "ClosedLoop.h"
#include "slalom/core/Rng.h"

namespace
{
using Eigen::Vector3d;
using slalom::core::Rng;
using slalom::test::AnalyticField;
using slalom::test::Obstacle;
using slalom::test::Sphere;
using slalom::test::VerticalCylinder;
using namespace slalom::local_planner::detail;

Eigen::Matrix3Xd line(const Vector3d& from, const Vector3d& step, Eigen::Index points)
{
  Eigen::Matrix3Xd positions(3, points);
  for (Eigen::Index k = 0; k < points; ++k) positions.col(k) = from + static_cast<double>(k) * step;
  return positions;
}

TEST(CloseObstacles, PointsLieOnSurfacesAndAreDistinct)
{
  std::size_t seen = 0;
  for (std::uint64_t seed = 1; seed <= 300; ++seed)
  {
    SCOPED_TRACE(seed);
    Rng rng(seed);
    std::vector<Obstacle> obstacles;
    for (int i = 0; i < 12; ++i)
    {
      const Vector3d c = rng.uniform3(-3.0, 3.0);
      if (i % 2)
        obstacles.push_back(Sphere{c, rng.uniform(0.1, 0.5)});
      else
        obstacles.push_back(VerticalCylinder{c.head<2>(), rng.uniform(0.1, 0.4)});
    }
    const AnalyticField field(obstacles);
    const auto path = line(rng.uniform3(-2.0, 2.0), 0.12 * rng.direction(), 16);
    if (field.signedDistance(path.col(0)) < 0.05) continue;
    const CloseObstacles close = collectCloseObstacles(field, path, 0.35, 1.45);
    EXPECT_TRUE(close.finite);
    seen += close.points_L.size();
    for (std::size_t i = 0; i < close.points_L.size(); ++i)
    {
      EXPECT_LE(std::abs(field.signedDistance(close.points_L[i])), 0.1 + 1e-9);
      for (std::size_t j = 0; j < i; ++j)
        EXPECT_GE((close.points_L[i] - close.points_L[j]).norm(), 0.1);
    }
    // The nearest obstacle of the vehicle is never missed.
    const double d = field.signedDistance(path.col(0));
    if (d > 1.3) continue;
    double nearest = 1e9;
    for (const Vector3d& point : close.points_L)
      nearest = std::min(nearest, (point - path.col(0)).norm());
    EXPECT_NEAR(nearest, d, 0.2);
  }
  EXPECT_GT(seen, 500u);
}

TEST(CloseObstacles, BothSidesOfAGapAreSeen)
{
  // On the axis of symmetry the gradient points at neither.
  for (const double offset : {0.0, 1e-9, 0.05})
  {
    SCOPED_TRACE(offset);
    const AnalyticField field(
        {VerticalCylinder{{1.0, 0.8}, 0.3}, VerticalCylinder{{1.0, -0.8}, 0.3}});
    const auto path = line(Vector3d(0.0, offset, 1.0), Vector3d(0.1, 0.0, 0.0), 16);
    const CloseObstacles close = collectCloseObstacles(field, path, 0.35, 1.45);
    const auto around = nearestAround(path.col(10), close.points_L, 2, 1.45);
    ASSERT_EQ(around.size(), 2u);
    EXPECT_LT(around[0].y() * around[1].y(), 0.0);
    for (const Vector3d& point : close.points_L)
      EXPECT_LE(std::abs(field.signedDistance(point)), 0.1);
  }
}

TEST(CloseObstacles, AnchorsStayOnTheVehiclesSide)
{
  const AnalyticField field({Eigen::AlignedBox3d(Vector3d(1.0, -5, -5), Vector3d(1.4, 5, 5))});
  const auto through = line(Vector3d(0.0, 0.0, 1.0), Vector3d(0.15, 0.0, 0.0), 16);
  const CloseObstacles close = collectCloseObstacles(field, through, 0.35, 1.45);
  for (Eigen::Index k = 0; k < 16; ++k) EXPECT_LT(close.anchors(0, k), 0.66);
  for (const Vector3d& point : close.points_L) EXPECT_NEAR(point.x(), 1.0, 1e-6);
}

TEST(CloseObstacles, NothingIsSeenOutsideTheFieldAndNanIsNoticed)
{
  const AnalyticField small({Sphere{Vector3d(0, 0, 0), 0.5}},
                            {Vector3d(-1, -1, -1), Vector3d(1, 1, 1)});
  const auto far = line(Vector3d(5.0, 0.0, 0.0), Vector3d(0.1, 0.0, 0.0), 5);
  EXPECT_TRUE(collectCloseObstacles(small, far, 0.35, 1.45).points_L.empty());
  EXPECT_FALSE(collectCloseObstacles(slalom::test::BrokenField(), far, 0.35, 1.45).finite);
}

}  // namespace
