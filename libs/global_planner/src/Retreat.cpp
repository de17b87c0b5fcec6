// SPDX-License-Identifier: BSD-3-Clause
#include "slalom/global_planner/Retreat.h"

#include <algorithm>
#include <cmath>

namespace slalom::global_planner
{
namespace
{
using core::DistanceField;
using core::UnknownAs;
using Eigen::Vector3d;

/// True if the straight way only leads away from what is near.
bool leadsAway(const DistanceField& field, const Vector3d& from, const Vector3d& to)
{
  const auto start = field.distance(from, UnknownAs::Free);
  if (!start) return false;
  const double tolerated = *start - 0.25 * field.resolution();
  const int steps =
      std::max(1, static_cast<int>(std::ceil((to - from).norm() / (0.25 * field.resolution()))));
  for (int i = 1; i <= steps; ++i)
  {
    const auto here =
        field.distance(from + (to - from) * (static_cast<double>(i) / steps), UnknownAs::Free);
    if (!here || *here < tolerated) return false;
  }
  return true;
}

std::optional<Vector3d> upTheGradient(const DistanceField& field, const Vector3d& place,
                                      double clearance, double reach)
{
  const double longest = 0.5 * field.resolution();
  const int most_steps = static_cast<int>(std::ceil(3.0 * reach / longest));
  Vector3d p = place;
  for (int i = 0; i < most_steps; ++i)
  {
    const auto here = field.sample(p, UnknownAs::Free);
    if (!here || (p - place).norm() > reach) return std::nullopt;
    if (here->distance >= clearance) return p;
    const double steepness = here->gradient.norm();
    if (steepness < 0.1) return std::nullopt;  // on a ridge, or deep inside an obstacle
    p += here->gradient * (std::min(longest, clearance - here->distance + 1e-6) / steepness);
  }
  return std::nullopt;
}

std::optional<Vector3d> nearestOnGrid(const DistanceField& field, const Vector3d& place,
                                      double clearance, double reach)
{
  const double step = field.resolution();
  const int n = static_cast<int>(std::floor(reach / step));
  std::optional<Vector3d> nearest;
  double best = reach;
  for (int z = -n; z <= n; ++z)
    for (int y = -n; y <= n; ++y)
      for (int x = -n; x <= n; ++x)
      {
        const Vector3d offset = step * Vector3d(x, y, z);
        if (offset.norm() >= best) continue;
        const auto there = field.distance(place + offset, UnknownAs::Free);
        if (!there || *there < clearance || !leadsAway(field, place, place + offset)) continue;
        best = offset.norm();
        nearest = place + offset;
      }
  return nearest;
}
}  // namespace

std::optional<Vector3d> findRetreat(const DistanceField& field, const Vector3d& place_L,
                                    double clearance, double reach)
{
  const auto here = field.distance(place_L, UnknownAs::Free);
  if (!here) return std::nullopt;
  if (*here >= clearance) return place_L;
  const auto up = upTheGradient(field, place_L, clearance, reach);
  if (up && leadsAway(field, place_L, *up)) return up;
  return nearestOnGrid(field, place_L, clearance, reach);
}

}  // namespace slalom::global_planner
