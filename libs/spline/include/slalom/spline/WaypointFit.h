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
 *  A C1 path through the waypoints, straight in the middle of long legs, is flown as fast as the
 * per-axis limits allow and sampled as control points, which can raise no limit and moves the curve
 * by at most max_acceleration knot_span^2 / 6 per axis; should rounding still exceed a limit, time
 * is stretched until no derivative control point does. The knot span is kept. Turns sharper than
 * about 150 degrees are taken at rest. Consecutive waypoints within 1 mm are merged; both ends are
 * met exactly, with zero velocity and acceleration.
 *  @param waypoints 3xM [m], M >= 2 distinct
 *  @throws std::invalid_argument on fewer than two distinct waypoints, non-finite values or
 * non-positive limits
 *  @see [Paper Sec. III-A], deviation D-01 (docs/paper_map.md): time allocation depends on length
 * and limits */
[[nodiscard]] UniformBSpline fitWaypoints(const Eigen::Matrix3Xd& waypoints,
                                          const FitLimits& limits);

}  // namespace slalom::spline
