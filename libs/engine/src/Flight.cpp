// SPDX-License-Identifier: BSD-3-Clause
#include "Flight.h"

#include <algorithm>
#include <utility>

#include "slalom/spline/WaypointFit.h"

namespace slalom::engine
{
namespace
{
/// Distance to the leg a-b, and how far along it the nearest point lies, in [0, 1].
std::pair<double, double> distanceToLeg(const Eigen::Vector3d& p, const Eigen::Vector3d& a,
                                        const Eigen::Vector3d& b)
{
  const double length2 = (b - a).squaredNorm();
  const double u = length2 > 0.0 ? std::clamp((p - a).dot(b - a) / length2, 0.0, 1.0) : 0.0;
  return {(a + u * (b - a) - p).norm(), u};
}

/// Index of the first waypoint to fly to: 0, or the end of the leg that the vehicle has already
/// joined.
Eigen::Index firstAhead(const Eigen::Matrix3Xd& waypoints, const Eigen::Vector3d& p_W)
{
  constexpr double kAtWaypoint_m = 1.0, kJoin_m = 3.0;
  const bool at_first = (waypoints.col(0) - p_W).norm() < kAtWaypoint_m;
  Eigen::Index first = at_first && waypoints.cols() > 1 ? 1 : 0;
  double nearest = kJoin_m;
  // Only consecutive legs: a mission that comes back to its start is not cut short.
  for (Eigen::Index leg = 0; leg + 1 < waypoints.cols(); ++leg)
  {
    const auto [distance, along] = distanceToLeg(p_W, waypoints.col(leg), waypoints.col(leg + 1));
    if (distance >= nearest || along <= 0.0) break;
    nearest = distance;
    first = leg + 1;
  }
  return first;
}

}  // namespace

Flight::Flight(std::uint64_t mission_number, spline::UniformBSpline reference,
               const Eigen::Vector3d& frame_offset, const core::Vehicle& planned, bool blind)
    : number(mission_number),
      reference_W(std::move(reference)),
      length(reference_W.length(reference_W.start(), reference_W.end()))
{
  if (blind)
    law = std::make_shared<const spline::TimeLaw>(
        reference_W, reference_W.start(), reference_W.end(), 1.0,
        spline::MotionLimits{planned.max_speed_mps, planned.max_acceleration_mps2});
  moveTo(frame_offset);
}

void Flight::moveTo(const Eigen::Vector3d& new_offset)
{
  offset = new_offset;
  reference_L = std::make_shared<const spline::UniformBSpline>(
      reference_W.withControlPoints(reference_W.controlPoints().colwise() + offset));
}

spline::UniformBSpline fitReference(const Mission& mission, const core::VehicleState& state,
                                    const EngineConfig& config)
{
  const Eigen::Index used = mission.waypoints_W.cols() - firstAhead(mission.waypoints_W, state.p_W);
  Eigen::Matrix3Xd waypoints(3, used + 1);
  waypoints.col(0) = state.p_W;
  waypoints.rightCols(used) = mission.waypoints_W.rightCols(used);
  check(Mission{waypoints}, config);
  // A vehicle that is already at its goal gets a reference all the same, of a length that nobody
  // notices.
  constexpr double kNothing_m = 0.02;
  if ((waypoints.colwise() - state.p_W).colwise().norm().maxCoeff() < kNothing_m)
    waypoints(0, 0) -= kNothing_m;
  spline::FitLimits limits;
  limits.max_speed = config.planned().max_speed_mps;
  limits.max_acceleration = config.planned().max_acceleration_mps2;
  limits.knot_span = config.mission.knot_span_s;
  return spline::fitWaypoints(waypoints, limits);
}

}  // namespace slalom::engine
