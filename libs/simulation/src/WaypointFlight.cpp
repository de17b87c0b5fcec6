// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "FlightPath.h"
#include "slalom/core/Math.h"
#include "slalom/spline/UniformBSpline.h"
#include "slalom/spline/WaypointFit.h"

namespace slalom::simulation
{
namespace
{
using spline::UniformBSpline;

constexpr double kYawStep = 0.02;  // [s]

struct YawKnot
{
  double t, yaw;
};

/// Headings that the vehicle should have, unwrapped, at equidistant times.
std::vector<double> headingsAlong(const UniformBSpline& curve, std::size_t count)
{
  constexpr double kSlow = 0.2;  // [m/s] below it a velocity has no meaningful direction
  std::vector<double> headings(count, 0.0);
  bool known = false;
  double heading = 0.0;
  for (std::size_t k = 0; k < count; ++k)
  {
    const Eigen::Vector3d v = curve.velocity(kYawStep * static_cast<double>(k));
    if (v.head<2>().norm() > kSlow)
    {
      const double seen = std::atan2(v.y(), v.x());
      heading = known ? heading + core::wrapAngle(seen - heading) : seen;
      // Before the first metre the vehicle already looks where it will fly.
      if (!known) std::fill_n(headings.begin(), k, heading);
      known = true;
    }
    headings[k] = heading;
  }
  return headings;
}

/// Headings between the yaws of waypoints, at the times when the curve passes them.
std::vector<double> headingsOf(const std::vector<Waypoint>& waypoints, const UniformBSpline& curve,
                               std::size_t count)
{
  std::vector<YawKnot> knots;
  double from = curve.start();
  for (const Waypoint& waypoint : waypoints)
  {
    from = curve.project(waypoint.p_W, from, curve.end());
    const double yaw = knots.empty()
                           ? waypoint.yaw
                           : knots.back().yaw + core::wrapAngle(waypoint.yaw - knots.back().yaw);
    knots.push_back({from, yaw});
  }
  std::vector<double> headings(count);
  std::size_t i = 0;
  for (std::size_t k = 0; k < count; ++k)
  {
    const double t = kYawStep * static_cast<double>(k);
    while (i + 2 < knots.size() && t > knots[i + 1].t) ++i;
    const YawKnot &a = knots[i], &b = knots[i + 1];
    const double u = b.t > a.t ? std::clamp((t - a.t) / (b.t - a.t), 0.0, 1.0) : 1.0;
    headings[k] = a.yaw + u * (b.yaw - a.yaw);
  }
  return headings;
}

/// Follows the headings as a critically damped servo with a rate limit would.
Eigen::Matrix3Xd followed(const std::vector<double>& headings, double max_rate)
{
  constexpr double kBandwidth = 4.0;  // [rad/s]
  Eigen::Matrix3Xd yaws = Eigen::Matrix3Xd::Zero(3, static_cast<Eigen::Index>(headings.size()));
  double yaw = headings.front(), rate = 0.0;
  for (std::size_t k = 0; k < headings.size(); ++k)
  {
    const double pull = kBandwidth * kBandwidth * (headings[k] - yaw) - 2.0 * kBandwidth * rate;
    rate = std::clamp(rate + pull * kYawStep, -max_rate, max_rate);
    yaw += rate * kYawStep;
    yaws(0, static_cast<Eigen::Index>(k)) = yaw;
  }
  return yaws;
}

/// Sampled yaws as control points: a convex combination keeps the rate limit and makes the heading
/// twice differentiable.
UniformBSpline yawCurve(const std::vector<Waypoint>& waypoints, const UniformBSpline& curve,
                        const FlightConfig& config)
{
  const double length = curve.duration() + config.hover_after_s;
  const std::size_t count = static_cast<std::size_t>(std::ceil(length / kYawStep)) + 4;
  const auto given = [](const Waypoint& w) { return !std::isnan(w.yaw); };
  const bool all = std::all_of(waypoints.begin(), waypoints.end(), given);
  if (!all && std::any_of(waypoints.begin(), waypoints.end(), given))
    throw std::invalid_argument("either all waypoints have a yaw or none has");
  const std::vector<double> headings =
      all ? headingsOf(waypoints, curve, count) : headingsAlong(curve, count);
  return UniformBSpline(followed(headings, config.max_yaw_rate_radps), kYawStep);
}

struct WaypointPath : ScriptedFlight::Path
{
  UniformBSpline curve, yaw;
  double hover_before, hover_after;

  WaypointPath(const std::vector<Waypoint>& waypoints, UniformBSpline fitted,
               const FlightConfig& config)
      : curve(std::move(fitted)),
        yaw(yawCurve(waypoints, curve, config)),
        hover_before(config.hover_before_s),
        hover_after(config.hover_after_s)
  {
  }

  Sample at(double t) const override
  {
    const double s = t - hover_before;
    const double heading = yaw.position(s).x();
    if (s < 0.0 || s > curve.end())
      return {curve.position(s), Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero(), heading};
    return {curve.position(s), curve.velocity(s), curve.acceleration(s), heading};
  }
  double duration() const override { return hover_before + curve.duration() + hover_after; }
};
}  // namespace

ScriptedFlight ScriptedFlight::through(const std::vector<Waypoint>& waypoints,
                                       const FlightConfig& config)
{
  Eigen::Matrix3Xd points(3, static_cast<Eigen::Index>(waypoints.size()));
  for (std::size_t k = 0; k < waypoints.size(); ++k)
    points.col(static_cast<Eigen::Index>(k)) = waypoints[k].p_W;
  spline::FitLimits limits;
  limits.max_speed = config.speed_mps;
  limits.max_acceleration = config.acceleration_mps2;
  return ScriptedFlight(
      std::make_unique<WaypointPath>(waypoints, spline::fitWaypoints(points, limits), config));
}

}  // namespace slalom::simulation
