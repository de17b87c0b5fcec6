// SPDX-License-Identifier: BSD-3-Clause
#include "Shortcut.h"

#include <algorithm>
#include <cmath>

#include "Lattice.h"

namespace slalom::search::detail
{
namespace
{
/// Points where a path turns, with both ends.
std::vector<Eigen::Vector3d> corners(const std::vector<Eigen::Vector3d>& path)
{
  std::vector<Eigen::Vector3d> kept = {path.front()};
  for (std::size_t i = 1; i + 1 < path.size(); ++i)
  {
    const Eigen::Vector3d before = path[i] - kept.back(), after = path[i + 1] - path[i];
    if (before.cross(after).norm() > 1e-9 || before.dot(after) < 0.0) kept.push_back(path[i]);
  }
  kept.push_back(path.back());
  return kept;
}

/// Cost of a straight piece, sampled about once per voxel.
double costOf(const core::DistanceField& field, const Eigen::Vector3d& a, const Eigen::Vector3d& b,
              const GridSearchConfig& config)
{
  const double length = (b - a).norm();
  if (config.proximity_weight == 0.0) return length;
  const double count = std::max(1.0, std::ceil(length / field.resolution()));
  double sum = 0.0;
  for (double i = 0.5; i < count; i += 1.0)
  {
    const Eigen::Vector3d p = a + (b - a) * (i / count);
    sum += costPerMetre(field.distance(p, core::UnknownAs::Free).value_or(0.0), config);
  }
  return length * sum / count;
}
}  // namespace

std::vector<Eigen::Vector3d> shortcut(const core::DistanceField& field,
                                      const std::vector<Eigen::Vector3d>& path,
                                      const GridSearchConfig& config)
{
  const std::vector<Eigen::Vector3d> points = corners(path);
  std::vector<double> cost = {0.0};  // up to each point
  for (std::size_t i = 1; i < points.size(); ++i)
    cost.push_back(cost.back() + costOf(field, points[i - 1], points[i], config));

  std::vector<Eigen::Vector3d> kept = {points.front()};
  for (std::size_t at = 0; at + 1 < points.size();)
  {
    std::size_t next = points.size() - 1;
    for (; next > at + 1; --next)
      if (segmentClear(field, points[at], points[next], config.clearance_m) &&
          costOf(field, points[at], points[next], config) <= cost[next] - cost[at] + 1e-9)
        break;
    kept.push_back(points[next]);
    at = next;
  }
  return kept;
}

}  // namespace slalom::search::detail
