// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "AnalyticField.h"
#include "InterpolatedField.h"
#include "slalom/core/Rng.h"
#include "slalom/search/GridSearch.h"

namespace slalom::search
{
inline std::vector<test::Obstacle> forest(core::Rng& rng, int trunks, double half_side)
{
  std::vector<test::Obstacle> obstacles;
  for (int i = 0; i < trunks; ++i)
    obstacles.push_back(test::VerticalCylinder{
        {rng.uniform(-half_side, half_side), rng.uniform(-half_side, half_side)},
        rng.uniform(0.1, 0.4)});
  return obstacles;
}

inline double clearanceOf(const core::DistanceField& field, const Eigen::Vector3d& p)
{
  return field.distance(p, core::UnknownAs::Free).value_or(-1.0);
}

/// Smallest distance along a segment, sampled every `step`.
inline double sampledClearance(const core::DistanceField& field, const Eigen::Vector3d& a,
                               const Eigen::Vector3d& b, double step)
{
  const int count = std::max(1, static_cast<int>(std::ceil((b - a).norm() / step)));
  double least = std::numeric_limits<double>::infinity();
  for (int i = 0; i <= count; ++i)
    least = std::min(least, clearanceOf(field, a + (b - a) * (static_cast<double>(i) / count)));
  return least;
}

inline void expectValidPath(const core::DistanceField& field, const SearchResult& result,
                            const Eigen::Vector3d& start, const Eigen::Vector3d& goal,
                            const Eigen::AlignedBox3d& box, double clearance)
{
  ASSERT_GE(result.path.cols(), 2);
  EXPECT_EQ(result.path.leftCols<1>(), start);
  EXPECT_EQ(result.path.rightCols<1>(), goal);
  EXPECT_EQ(result.nearest_L, goal);
  double length = 0.0;
  for (Eigen::Index i = 1; i < result.path.cols(); ++i)
  {
    const Eigen::Vector3d a = result.path.col(i - 1), b = result.path.col(i);
    EXPECT_GE(sampledClearance(field, a, b, 0.004), clearance - 1e-3);
    EXPECT_LT(box.exteriorDistance(b), 1e-9);
    length += (b - a).norm();
  }
  EXPECT_NEAR(result.length_m, length, 1e-9);
}

}  // namespace slalom::search
