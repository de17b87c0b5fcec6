// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "slalom/spline/TimeLaw.h"
#include "slalom/spline/UniformBSpline.h"

namespace slalom::global_planner
{
/// How a plan ends.
enum class PlanEnd
{
  OnReference,    ///< R goes on behind it, or ends there
  NearGoal,       ///< at rest at the reachable point nearest to a goal that is blocked
  NearReference,  ///< at rest at the reachable point nearest to where R could be met again
  Braking         ///< at rest where the vehicle can stop: no way on was found from here
};

/** The refined reference: what the vehicle is to fly from now on, and the promise that goes with
 * it. Its curve has R's knot span, but as many control points as its way needs; its parameter
 * continues that of the plan before it. Immutable, shared between planners. */
struct RefinedReference
{
  spline::UniformBSpline spline;
  Eigen::VectorXd along;  ///< per control point the parameter of R that it stands for [s]
  spline::TimeLaw law;    ///< how fast the parameter runs: limits hold, at rest at stop_at
  PlanEnd end = PlanEnd::OnReference;

  /// [s] Parameter up to which the curve is proved to keep the vehicle's radius from every known
  /// obstacle.
  double clear_until = 0.0;
  /// [s] <= clear_until. The vehicle rests here at the latest; everything before lies in known free
  /// space.
  double stop_at = 0.0;
  std::uint64_t sequence = 0;  ///< counts plans
  std::uint64_t map_sequence = 0;

  /// Parameter of R that the curve at t stands for [s].
  [[nodiscard]] double referenceTime(double t) const;
};

}  // namespace slalom::global_planner
