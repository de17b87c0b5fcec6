// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "slalom/spline/UniformBSpline.h"

namespace slalom::spline
{
/// Limits of a fit. Per-axis limits hold on the whole curve through the hulls of the derivative
/// splines.
struct FitLimits
{
  double max_speed = 1.2;         ///< [m/s] per axis
  double max_acceleration = 1.0;  ///< [m/s^2] per axis
  double knot_span = 0.2;         ///< [s]
};

/** Reference R: rest to rest through the waypoints, limits on velocity and acceleration kept
 * everywhere.
 *
 *  A smooth path through the waypoints is given a speed profile (curvature, speed and acceleration
 * limits, zero at both ends) and fitted by a uniform cubic B-spline with zero velocity and
 * acceleration at its ends; if a derivative control point still exceeds a limit, time is stretched
 * until none does. Duplicate consecutive waypoints are merged.
 *  @param waypoints 3xM [m], M >= 2 distinct
 *  @throws std::invalid_argument on fewer than two distinct waypoints, non-finite values or
 * non-positive limits
 *  @see [Paper Sec. III-A], deviation D-01 (docs/paper_map.md): time allocation depends on length
 * and limits */
[[nodiscard]] UniformBSpline fitWaypoints(const Eigen::Matrix3Xd& waypoints,
                                          const FitLimits& limits);

}  // namespace slalom::spline
