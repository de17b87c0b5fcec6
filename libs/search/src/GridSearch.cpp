// SPDX-License-Identifier: BSD-3-Clause
#include "slalom/search/GridSearch.h"

#include <algorithm>
#include <cmath>

#include "PathFinder.h"

namespace slalom::search
{
SearchResult findPath(const core::DistanceField& field, const Eigen::Vector3d& start_L,
                      const Eigen::Vector3d& goal_L, const Eigen::AlignedBox3d& box_L,
                      const GridSearchConfig& config)
{
  return detail::PathFinder(field, start_L, goal_L, box_L, config).first();
}

bool segmentClear(const core::DistanceField& field, const Eigen::Vector3d& a_L,
                  const Eigen::Vector3d& b_L, double clearance_m)
{
  constexpr double kFinest = 1e-3;  // [m] least step; a dip between two steps is half as deep
  const double length = (b_L - a_L).norm();
  if (!std::isfinite(length)) return false;
  const Eigen::Vector3d direction = length > 0.0 ? ((b_L - a_L) / length).eval() : b_L - a_L;
  for (double at = 0.0;;)
  {
    const auto distance =
        field.distance(at < length ? (a_L + at * direction).eval() : b_L, core::UnknownAs::Free);
    if (!distance || !(*distance >= clearance_m)) return false;
    if (at >= length) return true;
    at = std::min(length, at + std::max(kFinest, *distance - clearance_m));
  }
}

}  // namespace slalom::search
