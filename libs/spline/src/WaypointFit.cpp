// SPDX-License-Identifier: BSD-3-Clause
#include "slalom/spline/WaypointFit.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>
#include <vector>

#include "SpeedProfile.h"
#include "WaypointPath.h"

namespace slalom::spline
{
namespace
{
constexpr double kMergeDistance = 1e-3;  ///< [m] nearer neighbours are one waypoint

void check(const Eigen::Matrix3Xd& waypoints, const FitLimits& limits)
{
  const auto positive = [](double value, const char* name)
  {
    if (!(value > 0.0) || !std::isfinite(value))
      throw std::invalid_argument(std::string("fitWaypoints: ") + name + " = " +
                                  std::to_string(value) + ", must be positive and finite");
  };
  positive(limits.max_speed, "max_speed");
  positive(limits.max_acceleration, "max_acceleration");
  positive(limits.knot_span, "knot_span");
  if (!waypoints.allFinite()) throw std::invalid_argument("fitWaypoints: a waypoint is not finite");
}

/// Drops waypoints that repeat the one before; the first and the last stay exactly.
Eigen::Matrix3Xd distinct(const Eigen::Matrix3Xd& waypoints)
{
  Eigen::Matrix3Xd kept(3, waypoints.cols());
  Eigen::Index count = 0;
  for (Eigen::Index i = 0; i < waypoints.cols(); ++i)
    if (count == 0 || (waypoints.col(i) - kept.col(count - 1)).norm() > kMergeDistance)
      kept.col(count++) = waypoints.col(i);
  if (count < 2) throw std::invalid_argument("fitWaypoints: fewer than two distinct waypoints");
  kept.col(count - 1) = waypoints.rightCols<1>();
  return kept.leftCols(count);
}

/** Control points sampled from the passage, stretched to last `spans - rest` knot spans. Three
 * equal points at each end give zero velocity and acceleration there. The first sample is taken a
 * little late: the rest that precedes it halves its second difference, and (sqrt(2) - 1) spans use
 * that up exactly under constant acceleration. */
constexpr double kLate = std::numbers::sqrt2 - 1.0;

UniformBSpline sampled(const detail::SpeedProfile& profile, Eigen::Index spans, double knot_span)
{
  const Eigen::Index n = spans + UniformBSpline::kDegree;
  const double moving = static_cast<double>(spans) - 2.0 + 2.0 * kLate;
  const double stretch = profile.duration() / moving;  // passage time per knot span
  Eigen::Matrix3Xd points(3, n);
  for (Eigen::Index j = 0; j < n; ++j)
    points.col(j) = profile.position(stretch * (static_cast<double>(j) - 2.0 + kLate));
  for (Eigen::Index j = 0; j < 3; ++j)
  {
    points.col(j) = profile.position(0.0);
    points.col(n - 1 - j) = profile.position(profile.duration());
  }
  return {std::move(points), knot_span};
}

/// By how much time must be stretched for every derivative control point to keep its limit.
double excess(const UniformBSpline& curve, const FitLimits& limits)
{
  const double speed = curve.velocityControlPoints().cwiseAbs().maxCoeff();
  const double acceleration = curve.accelerationControlPoints().cwiseAbs().maxCoeff();
  return std::max(speed / limits.max_speed, std::sqrt(acceleration / limits.max_acceleration));
}
}  // namespace

UniformBSpline fitWaypoints(const Eigen::Matrix3Xd& waypoints, const FitLimits& limits)
{
  check(waypoints, limits);
  // A right-angled corner of this reach can be taken at about full speed.
  const double corner_reach = 2.0 * limits.max_speed * limits.max_speed / limits.max_acceleration;
  const std::vector<detail::PathPiece> path =
      detail::pathThrough(distinct(waypoints), corner_reach);
  const detail::SpeedProfile profile(path, limits.max_speed, limits.max_acceleration);

  const double moving = profile.duration() / limits.knot_span;
  auto spans =
      std::max<Eigen::Index>(4, static_cast<Eigen::Index>(std::ceil(moving + 2.0 - 2.0 * kLate)));
  for (;;)
  {
    UniformBSpline curve = sampled(profile, spans, limits.knot_span);
    const double stretch = excess(curve, limits);
    if (stretch <= 1.0) return curve;
    spans = std::max(spans + 1,
                     static_cast<Eigen::Index>(std::ceil(static_cast<double>(spans) * stretch)));
  }
}

}  // namespace slalom::spline
