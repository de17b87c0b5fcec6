// SPDX-License-Identifier: BSD-3-Clause
#include "slalom/core/DistanceField.h"

#include <algorithm>
#include <cmath>

namespace slalom::core
{
std::optional<double> DistanceField::distance(const Eigen::Vector3d& p_L, UnknownAs unknown) const
{
  const std::optional<DistanceSample> here = sample(p_L, unknown);
  return here ? std::optional<double>(here->distance) : std::nullopt;
}

double DistanceField::hullBound(const Hull4& hull_L, UnknownAs unknown, double limit) const
{
  const Eigen::Vector3d centre = 0.5 * (hull_L.col(0) + hull_L.col(3));
  const double radius = std::sqrt((hull_L.colwise() - centre).colwise().squaredNorm().maxCoeff());
  return std::min(limit, boundEverywhere(centre, unknown) - radius);
}

double DistanceField::boundEverywhere(const Eigen::Vector3d& p_L, UnknownAs unknown) const
{
  const Eigen::AlignedBox3d box = bounds();
  if (const std::optional<double> inside = lowerBound(p_L, unknown))
  {
    if (unknown == UnknownAs::Free) return *inside;
    // lowerBound() may know of unknown voxels outside the box, but not that the box ends where it
    // does.
    return std::min({*inside, (p_L - box.min()).minCoeff(), (box.max() - p_L).minCoeff()});
  }
  if (unknown == UnknownAs::Occupied) return 0.0;
  // Two bounds hold outside: distances change by at most the length of a step, and every obstacle
  // lies in a voxel whose centre is inside the box.
  constexpr double kRounding = 1e-9;  // [m]
  const Eigen::Vector3d nearest = p_L.cwiseMax(box.min()).cwiseMin(box.max());
  const double continued = lowerBound(nearest, unknown).value_or(0.0) - (p_L - nearest).norm();
  const Eigen::Vector3d half = Eigen::Vector3d::Constant(0.5 * resolution());
  const Eigen::AlignedBox3d voxels(box.min() - half, box.max() + half);
  return std::max(0.0, std::max(continued, voxels.exteriorDistance(p_L)) - kRounding);
}

}  // namespace slalom::core
