// SPDX-License-Identifier: BSD-3-Clause
#include "CloseObstacles.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace slalom::local_planner::detail
{
namespace
{
using Eigen::Vector3d;

constexpr double kSame = 0.1;          // [m] two points this near are one
constexpr double kBehind = 0.05;       // [m] least depth of the point behind a probe
constexpr double kFlatGradient = 0.3;  // [1] below this a direction means nothing (ties)
constexpr int kProjections = 3;
constexpr double kSameSide = 0.7;  // cosine; 45 degrees

class Collector
{
 public:
  Collector(const core::DistanceField& field, double reach, CloseObstacles& close)
      : field_(field), reach_(reach), close_(close)
  {
  }

  /// The field at p; free and far where it knows nothing.
  core::DistanceSample at(const Vector3d& p)
  {
    core::DistanceSample here{field_.maxDistance(), Vector3d::Zero()};
    if (const auto known = field_.sample(p, core::UnknownAs::Free)) here = *known;
    close_.finite = close_.finite && std::isfinite(here.distance) && here.gradient.allFinite();
    return here;
  }

  /// Keeps the obstacle point nearest to p. Where two obstacles are equally far the gradient points
  /// between them, so there the neighbourhood is asked.
  void keepNearest(const Vector3d& p, const core::DistanceSample& here)
  {
    if (!(here.distance <= reach_)) return;
    if (keepSurfacePoint(p, here)) return;
    const double aside = std::max(field_.resolution(), 0.25 * here.distance);
    for (int axis = 0; axis < 3; ++axis)
      for (const double sign : {-aside, aside})
      {
        const Vector3d q = p + sign * Vector3d::Unit(axis);
        keepSurfacePoint(q, at(q));
      }
  }

 private:
  /// Follows the gradient from p down to the surface; false if it does not lead there.
  bool keepSurfacePoint(const Vector3d& p, const core::DistanceSample& here)
  {
    const double slope = here.gradient.norm();
    if (!(slope >= kFlatGradient)) return false;
    Vector3d point = p - std::max(here.distance, kBehind) / slope * here.gradient;
    for (int i = 0; i < kProjections && here.distance > 0.0; ++i)
    {
      const core::DistanceSample there = at(point);
      if (there.distance <= 0.5 * field_.resolution()) break;
      if (i + 1 == kProjections || !(there.gradient.norm() >= kFlatGradient)) return false;
      point -= there.distance * there.gradient.normalized();
    }
    const bool known = std::any_of(close_.points_L.begin(), close_.points_L.end(),
                                   [&](const Vector3d& other)
                                   { return (other - point).squaredNorm() < kSame * kSame; });
    if (!known) close_.points_L.push_back(point);
    return true;
  }

  const core::DistanceField& field_;
  double reach_;
  CloseObstacles& close_;
};
}  // namespace

CloseObstacles collectCloseObstacles(const core::DistanceField& field,
                                     const Eigen::Matrix3Xd& expected, double radius, double reach)
{
  CloseObstacles close;
  close.anchors = expected;
  Collector collector(field, reach, close);
  double depth = -std::numeric_limits<double>::infinity();  // the vehicle itself is always taken
  for (Eigen::Index k = 0; k < expected.cols() && close.finite; ++k)
  {
    const core::DistanceSample here = collector.at(expected.col(k));
    if (here.distance < std::min(radius, depth))
    {
      const Vector3d last_good = close.anchors.col(k - 1);
      close.anchors.rightCols(expected.cols() - k).colwise() = last_good;
      break;
    }
    depth = here.distance;
    collector.keepNearest(expected.col(k), here);
    // Between two obstacles the field shows only the nearer one; look from the other side, too.
    const Vector3d across = expected.col(k) + std::max(here.distance, 0.0) * here.gradient;
    if (here.distance < reach) collector.keepNearest(across, collector.at(across));
  }
  return close;
}

std::vector<Vector3d> nearestAround(const Vector3d& p, const std::vector<Vector3d>& points,
                                    int count, double reach)
{
  std::vector<Vector3d> chosen;
  while (static_cast<int>(chosen.size()) < count)
  {
    const Vector3d* best = nullptr;
    double best_distance = reach;
    for (const Vector3d& point : points)
    {
      const double distance = (point - p).norm();
      if (distance >= best_distance) continue;
      const bool covered = std::any_of(
          chosen.begin(), chosen.end(),
          [&](const Vector3d& other)
          { return (other - p).dot(point - p) >= kSameSide * (other - p).norm() * distance; });
      if (covered) continue;
      best = &point;
      best_distance = distance;
    }
    if (!best) break;
    chosen.push_back(*best);
  }
  return chosen;
}

}  // namespace slalom::local_planner::detail
