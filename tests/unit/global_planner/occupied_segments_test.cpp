// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "AnalyticField.h"
#include "slalom/core/Rng.h"
#include "slalom/global_planner/OccupiedSegments.h"

namespace slalom::global_planner
{
namespace
{
spline::UniformBSpline randomCurve(core::Rng& rng)
{
  Eigen::Matrix3Xd points(3, 30);
  Eigen::Vector3d p(0, 0, 1);
  for (auto column : points.colwise())
    column = p +=
        Eigen::Vector3d(rng.uniform(0, 0.4), rng.uniform(-0.3, 0.3), rng.uniform(-0.1, 0.1));
  return {points, 0.2};
}

TEST(OccupiedSegments, AgreeWithDenseSampling)
{
  for (std::uint64_t seed = 0; seed < 200; ++seed)
  {
    SCOPED_TRACE(seed);
    core::Rng rng(seed);
    std::vector<test::Obstacle> trees;
    for (int k = 0; k < 6; ++k)
      trees.push_back(
          test::VerticalCylinder{{rng.uniform(0, 6), rng.uniform(-2, 2)}, rng.uniform(0.1, 0.5)});
    const test::AnalyticField field(trees);
    const spline::UniformBSpline curve = randomCurve(rng);
    const double clearance = rng.uniform(0.2, 0.8);
    const auto segments =
        findOccupiedSegments(curve, curve.start(), curve.end(), field, clearance, 0.0);
    for (int i = 0; i <= 5000; ++i)
    {
      const double t = curve.start() + curve.duration() * i / 5000.0;
      const bool inside = std::any_of(segments.begin(), segments.end(),
                                      [t](const auto& s) { return t >= s.from && t <= s.to; });
      const double distance = *field.distance(curve.position(t), core::UnknownAs::Free);
      // Between two samples half a voxel apart a graze of at most a quarter of a voxel may hide.
      EXPECT_TRUE(inside || distance >= clearance - 0.25 * field.resolution()) << t;
    }
    for (const auto& s : segments)
      EXPECT_LT(minClearance(curve, s.from, s.to, field), clearance + 0.5 * field.resolution());
  }
}

TEST(OccupiedSegments, SaysWhetherTheWindowsEndsAreFree)
{
  const test::AnalyticField field({test::Sphere{{0, 0, 1}, 0.5}, test::Sphere{{4, 0, 1}, 0.5}});
  Eigen::Matrix3Xd points(3, 24);
  for (Eigen::Index i = 0; i < 24; ++i) points.col(i) = Eigen::Vector3d(0.2 * double(i - 1), 0, 1);
  const spline::UniformBSpline curve(points, 0.2);
  const auto segments = findOccupiedSegments(curve, curve.start(), curve.end(), field, 0.3, 0.0);
  ASSERT_EQ(segments.size(), 2u);
  EXPECT_TRUE(segments[0].open_start);
  EXPECT_FALSE(segments[0].open_end);
  EXPECT_FALSE(segments[1].open_start);
  EXPECT_TRUE(segments[1].open_end);
}

}  // namespace
}  // namespace slalom::global_planner
