// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "slalom/core/Rng.h"
#include "slalom/global_planner/GradientVectors.h"

namespace slalom::global_planner
{
namespace
{
Eigen::Matrix3Xd halfSine(Eigen::Index points)
{
  Eigen::Matrix3Xd path(3, points);
  for (Eigen::Index k = 0; k < points; ++k)
  {
    const double x = static_cast<double>(k) / static_cast<double>(points - 1);
    path.col(k) = Eigen::Vector3d(x, std::sin(std::numbers::pi * x), 0.0);
  }
  return path;
}

TEST(Crossing, FindsEveryPointOfAHalfSine)
{
  // The printed rule of Algorithm 2 finds the middle point only.
  const Eigen::Matrix3Xd path = halfSine(21);
  for (int j = 1; j < 40; ++j)
  {
    const double x = j / 40.0, d = 0.5 / 40.0;
    const auto hit = crossing({x - d, 0, 0}, {x, 0, 0}, {x + d, 0, 0}, path);
    ASSERT_TRUE(hit) << x;
    EXPECT_NEAR(hit->x(), x, 1e-12);
    EXPECT_NEAR(hit->y(), std::sin(std::numbers::pi * x), 4e-3);
  }
}

TEST(Crossing, IsTheNearestPointOfThePathInThePlane)
{
  for (std::uint64_t seed = 0; seed < 500; ++seed)
  {
    SCOPED_TRACE(seed);
    core::Rng rng(seed);
    Eigen::Matrix3Xd path(3, rng.integer(2, 15));
    for (auto column : path.colwise()) column = rng.uniform3(-3, 3);
    const Eigen::Vector3d at = rng.uniform3(-1, 1), direction = rng.direction();
    const auto hit = crossing(at - 0.1 * direction, at, at + 0.1 * direction, path);
    double nearest = std::numeric_limits<double>::infinity();
    for (Eigen::Index k = 0; k + 1 < path.cols(); ++k)
      for (int i = 0; i < 2000; ++i)
      {
        const Eigen::Vector3d a = path.col(k) + (path.col(k + 1) - path.col(k)) * (i / 2000.0);
        const Eigen::Vector3d b =
            path.col(k) + (path.col(k + 1) - path.col(k)) * ((i + 1) / 2000.0);
        if ((a - at).dot(direction) * (b - at).dot(direction) <= 0.0)
          nearest = std::min(nearest, (a - at).norm());
      }
    ASSERT_EQ(hit.has_value(), std::isfinite(nearest));
    if (!hit) continue;
    EXPECT_NEAR((*hit - at).dot(direction), 0.0, 1e-9);
    EXPECT_NEAR((*hit - at).norm(), nearest, 0.01);
  }
}

TEST(Crossing, ToleratesDegenerateInput)
{
  const Eigen::Vector3d p(0.5, 0.0, 0.0);
  EXPECT_FALSE(crossing(p, p, p, halfSine(5)));
  EXPECT_FALSE(crossing(p, p, p + Eigen::Vector3d::UnitX(), Eigen::Matrix3Xd(3, 0)));
  EXPECT_FALSE(crossing(p, p, p + Eigen::Vector3d::UnitX(), Eigen::Matrix3Xd::Zero(3, 3)));
}

}  // namespace
}  // namespace slalom::global_planner
