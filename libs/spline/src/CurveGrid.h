// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <vector>

#include "Reachability.h"
#include "slalom/spline/TimeLaw.h"
#include "slalom/spline/UniformBSpline.h"

namespace slalom::spline::detail
{
/// Quarters of the knot spans between two parameters, with the limits of a motion along the curve.
struct CurveGrid
{
  std::vector<double> times;  ///< intervals + 1
  std::vector<IntervalLimits> intervals;
};

/** The grid belongs to the curve, not to the stretch: a law that starts inside another one's
 * interval finds that law's way on feasible, because limits on Bernstein coefficients are inherited
 * by parts of the interval.
 *  @param from,to in the domain, from < to */
[[nodiscard]] CurveGrid makeGrid(const UniformBSpline& curve, double from, double to,
                                 const MotionLimits& limits, std::span<const double> span_speeds);

}  // namespace slalom::spline::detail
