// SPDX-License-Identifier: BSD-3-Clause
#include "Shortcut.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace slalom::search::detail
{
namespace
{
/// Points where a path turns, with both ends.
Path corners(const Path& path)
{
  Path kept = {path.front()};
  for (std::size_t i = 1; i + 1 < path.size(); ++i)
  {
    const Eigen::Vector3d before = path[i] - kept.back(), after = path[i + 1] - path[i];
    if (before.cross(after).norm() > 1e-9 || before.dot(after) < 0.0) kept.push_back(path[i]);
  }
  kept.push_back(path.back());
  return kept;
}

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Cost of a straight piece, sampled about once per voxel. Infinite as soon as it is seen to be
/// dearer than `most`, or, if there is such a limit, too near to an obstacle.
double costOf(const core::DistanceField& field, const Eigen::Vector3d& a, const Eigen::Vector3d& b,
              const GridSearchConfig& config, double most = kInfinity)
{
  const double length = (b - a).norm();
  if (config.proximity_weight == 0.0) return length <= most ? length : kInfinity;
  const double count = std::max(1.0, std::ceil(length / field.resolution()));
  double cost = 0.0;
  for (double i = 0.5; i < count; i += 1.0)
  {
    const Eigen::Vector3d p = a + (b - a) * (i / count);
    const double distance = field.distance(p, core::UnknownAs::Free).value_or(0.0);
    cost += length / count * costPerMetre(pricedDistance(field, p, distance, config), config);
    if (cost > most || (distance < config.clearance_m && most < kInfinity)) return kInfinity;
  }
  return cost;
}
}  // namespace

PricedPath shortcut(const core::DistanceField& field, const Path& path,
                    const GridSearchConfig& config, const Lattice& lattice, Walls walls)
{
  const Path points = corners(path);
  std::vector<double> cost = {0.0};  // up to each point
  for (std::size_t i = 1; i < points.size(); ++i)
    cost.push_back(cost.back() + costOf(field, points[i - 1], points[i], config));

  PricedPath kept{{points.front()}, 0.0};
  for (std::size_t at = 0; at + 1 < points.size();)
  {
    std::size_t next = points.size() - 1;
    double straight = 0.0;
    for (; next > at + 1; --next)
    {
      straight = costOf(field, points[at], points[next], config, cost[next] - cost[at] + 1e-9);
      if (straight < kInfinity && !lattice.crosses(walls, points[at], points[next]) &&
          segmentClear(field, points[at], points[next], config.clearance_m))
        break;
    }
    if (next == at + 1) straight = cost[next] - cost[at];
    kept.points.push_back(points[next]);
    kept.cost += straight;
    at = next;
  }
  return kept;
}

}  // namespace slalom::search::detail
