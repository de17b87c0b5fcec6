// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "AnalyticField.h"

namespace slalom::test
{
/// An analytic field sampled on a grid and interpolated trilinearly: what a map's distance field
/// looks like to planners, at about its cost per query.
class InterpolatedField : public core::DistanceField
{
 public:
  InterpolatedField(const AnalyticField& exact, const Eigen::AlignedBox3d& bounds,
                    double resolution, double max_distance = 4.0)
      : bounds_(bounds), resolution_(resolution), max_distance_(max_distance)
  {
    size_ = ((bounds.max() - bounds.min()) / resolution).array().round().cast<int>() + 1;
    values_.reserve(static_cast<std::size_t>(size_.prod()));
    for (int k = 0; k < size_.z(); ++k)
      for (int j = 0; j < size_.y(); ++j)
        for (int i = 0; i < size_.x(); ++i)
        {
          const Eigen::Vector3d p = bounds.min() + resolution * Eigen::Vector3d(i, j, k);
          values_.push_back(static_cast<float>(std::min(exact.signedDistance(p), max_distance_)));
        }
  }

  core::Occupancy occupancy(const Eigen::Vector3d& p) const override
  {
    const auto here = sample(p, core::UnknownAs::Free);
    if (!here) return core::Occupancy::Unknown;
    return here->distance <= 0.0 ? core::Occupancy::Occupied : core::Occupancy::Free;
  }
  std::optional<core::DistanceSample> sample(const Eigen::Vector3d& p,
                                             core::UnknownAs) const override
  {
    if (!bounds_.contains(p)) return std::nullopt;
    const Eigen::Array3d at = ((p - bounds_.min()) / resolution_).array();
    const Eigen::Array3i cell = at.cast<int>().min(size_.array() - 2).max(0);
    const Eigen::Array3d u = at - cell.cast<double>(), v = 1.0 - u;
    const std::size_t nx = static_cast<std::size_t>(size_.x());
    const std::size_t nxy = nx * static_cast<std::size_t>(size_.y());
    const float* c =
        &values_[static_cast<std::size_t>(cell.x()) + nx * static_cast<std::size_t>(cell.y()) +
                 nxy * static_cast<std::size_t>(cell.z())];
    const auto edge = [&](std::size_t o) { return v.x() * c[o] + u.x() * c[o + 1]; };
    const auto slope = [&](std::size_t o) { return static_cast<double>(c[o + 1] - c[o]); };
    const double e00 = edge(0), e10 = edge(nx), e01 = edge(nxy), e11 = edge(nxy + nx);
    const double f0 = v.y() * e00 + u.y() * e10, f1 = v.y() * e01 + u.y() * e11;
    core::DistanceSample here;
    here.distance = v.z() * f0 + u.z() * f1;
    here.gradient.x() = (v.z() * (v.y() * slope(0) + u.y() * slope(nx)) +
                         u.z() * (v.y() * slope(nxy) + u.y() * slope(nxy + nx))) /
                        resolution_;
    here.gradient.y() = (v.z() * (e10 - e00) + u.z() * (e11 - e01)) / resolution_;
    here.gradient.z() = (f1 - f0) / resolution_;
    return here;
  }
  std::optional<double> lowerBound(const Eigen::Vector3d& p, core::UnknownAs unknown) const override
  {
    const auto here = sample(p, unknown);
    if (!here) return std::nullopt;
    return here->distance - std::sqrt(3.0) * resolution_;
  }
  /// Nothing is unknown here, so both treatments list the same: grid points inside obstacles.
  void collectObstacles(const Eigen::AlignedBox3d& box, core::UnknownAs,
                        std::vector<Eigen::Vector3d>& centres) const override
  {
    for (int k = 0; k < size_.z(); ++k)
      for (int j = 0; j < size_.y(); ++j)
        for (int i = 0; i < size_.x(); ++i)
          if (const Eigen::Vector3d p = bounds_.min() + resolution_ * Eigen::Vector3d(i, j, k);
              box.contains(p) && occupancy(p) == core::Occupancy::Occupied)
            centres.push_back(p);
  }
  Eigen::AlignedBox3d bounds() const override { return bounds_; }
  double resolution() const override { return resolution_; }
  double maxDistance() const override { return max_distance_; }

 private:
  Eigen::AlignedBox3d bounds_;
  double resolution_, max_distance_;
  Eigen::Vector3i size_;
  std::vector<float> values_;
};

}  // namespace slalom::test
