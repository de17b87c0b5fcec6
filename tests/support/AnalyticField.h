// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include "slalom/core/DistanceField.h"

namespace slalom::test
{
struct Sphere
{
  Eigen::Vector3d centre;
  double radius;
};
struct VerticalCylinder
{
  Eigen::Vector2d centre;
  double radius;
};
/// Anything with a signed distance.
struct Obstacle
{
  Obstacle(Sphere s)
      : distance([s](const Eigen::Vector3d& p) { return (p - s.centre).norm() - s.radius; })
  {
  }
  Obstacle(VerticalCylinder c)
      : distance([c](const Eigen::Vector3d& p)
                 { return (p.head<2>() - c.centre).norm() - c.radius; })
  {
  }
  Obstacle(Eigen::AlignedBox3d box)
      : distance(
            [box](const Eigen::Vector3d& p)
            {
              if (!box.contains(p)) return box.exteriorDistance(p);
              return -std::min((p - box.min()).minCoeff(), (box.max() - p).minCoeff());
            })
  {
  }

  std::function<double(const Eigen::Vector3d&)> distance;
};

/// A distance field of spheres, vertical cylinders and boxes, exact and known everywhere inside its
/// bounds.
class AnalyticField : public core::DistanceField
{
 public:
  explicit AnalyticField(std::vector<Obstacle> obstacles,
                         Eigen::AlignedBox3d bounds = {Eigen::Vector3d(-100, -100, -100),
                                                       Eigen::Vector3d(100, 100, 100)})
      : obstacles_(std::move(obstacles)), bounds_(bounds)
  {
  }

  core::Occupancy occupancy(const Eigen::Vector3d& p) const override
  {
    if (!bounds_.contains(p)) return core::Occupancy::Unknown;
    return signedDistance(p) <= 0.0 ? core::Occupancy::Occupied : core::Occupancy::Free;
  }
  std::optional<core::DistanceSample> sample(const Eigen::Vector3d& p,
                                             core::UnknownAs) const override
  {
    if (!bounds_.contains(p)) return std::nullopt;
    core::DistanceSample here;
    here.distance = std::min(signedDistance(p), maxDistance());
    constexpr double kStep = 1e-6;
    for (int axis = 0; axis < 3; ++axis)
    {
      const Eigen::Vector3d h = kStep * Eigen::Vector3d::Unit(axis);
      here.gradient[axis] = (std::min(signedDistance(p + h), maxDistance()) -
                             std::min(signedDistance(p - h), maxDistance())) /
                            (2.0 * kStep);
    }
    return here;
  }
  std::optional<double> lowerBound(const Eigen::Vector3d& p, core::UnknownAs) const override
  {
    if (!bounds_.contains(p)) return std::nullopt;
    return std::min(signedDistance(p), maxDistance());
  }
  /// Nothing is unknown here, so both treatments list the same: grid points inside obstacles.
  void collectObstacles(const Eigen::AlignedBox3d& box, core::UnknownAs,
                        std::vector<Eigen::Vector3d>& centres) const override
  {
    const Eigen::AlignedBox3d inside = box.intersection(bounds_);
    if (inside.isEmpty()) return;
    const double r = resolution();
    const Eigen::Vector3d lo = (inside.min() / r).array().floor() * r + 0.5 * r;
    for (double x = lo.x(); x <= inside.max().x(); x += r)
      for (double y = lo.y(); y <= inside.max().y(); y += r)
        for (double z = lo.z(); z <= inside.max().z(); z += r)
          if (const Eigen::Vector3d p(x, y, z); inside.contains(p) && signedDistance(p) <= 0.0)
            centres.push_back(p);
  }
  Eigen::AlignedBox3d bounds() const override { return bounds_; }
  double resolution() const override { return 0.2; }
  double maxDistance() const override { return 10.0; }

  double signedDistance(const Eigen::Vector3d& p) const
  {
    double nearest = 1e9;
    for (const Obstacle& obstacle : obstacles_) nearest = std::min(nearest, obstacle.distance(p));
    return nearest;
  }

 private:
  std::vector<Obstacle> obstacles_;
  Eigen::AlignedBox3d bounds_;
};

}  // namespace slalom::test
