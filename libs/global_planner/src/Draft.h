// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

#include "ReferenceWindow.h"
#include "slalom/core/VehicleState.h"
#include "slalom/global_planner/RefinedReference.h"

namespace slalom::global_planner
{
constexpr Eigen::Index kFixedAtEnd = 3;  ///< position, velocity and acceleration join R, or rest

/** Control points that may become a plan. The first `fixed` columns belong to the past and to the
 * span under the vehicle and stay what they are; the last three join R or a point to rest at;
 * those between are free, and as many as their way needs. */
struct Draft
{
  Eigen::Matrix3Xd points;  ///< 3xN control points [m]
  Eigen::VectorXd along;    ///< N: parameter of R that each stands for [s], non-decreasing
  double start = 0.0;       ///< [s] parameter of the first knot
  double knot_span = 0.2;   ///< [s]
  Eigen::Index fixed = 4;   ///< leading columns
  PlanEnd end = PlanEnd::OnReference;

  [[nodiscard]] Eigen::Index firstFree() const { return fixed; }
  [[nodiscard]] Eigen::Index lastFree() const { return points.cols() - 1 - kFixedAtEnd; }
  [[nodiscard]] bool hasFreePoints() const { return lastFree() >= firstFree(); }
  [[nodiscard]] spline::UniformBSpline curve() const { return {points, knot_span, start}; }
  /// Parameter at which control point `column` has most influence (Greville abscissa) [s].
  [[nodiscard]] double influence(Eigen::Index column) const
  {
    return start + knot_span * static_cast<double>(column - 1);
  }

  /// Replaces columns [first, last) by others.
  void replace(Eigen::Index first, Eigen::Index last, const Eigen::Matrix3Xd& points_L,
               const Eigen::VectorXd& stand_for);
  /// Appends a rest: three equal control points.
  void restAt(const Eigen::Vector3d& rest_L, PlanEnd why);
};

/// R itself from the vehicle's progress to the end of the window.
[[nodiscard]] Draft draftOfReference(const spline::UniformBSpline& r, double progress,
                                     const ReferenceWindow& window);

/// The previous plan from shortly behind the vehicle on, and R behind it up to the window's end.
/// A plan that rests away from R stays as it is.
[[nodiscard]] Draft draftOfPlan(const RefinedReference& plan, double progress,
                                const spline::UniformBSpline& r, const ReferenceWindow& window);

/** The first columns of `begin`, then R from its control point `join` to the end of the window.
 * The gap between them is for the caller to fill. */
[[nodiscard]] Draft draftBackToReference(const Draft& begin, const spline::UniformBSpline& r,
                                         Eigen::Index join, const ReferenceWindow& window);

/// Four columns that pass the vehicle's state with its velocity held; `progress` becomes their
/// start.
[[nodiscard]] Draft draftAtVehicle(const core::VehicleState& state, double progress, double along,
                                   double knot_span);

/// Where R's control points were when they stood for `along`: its control polygon, interpolated.
[[nodiscard]] Eigen::Matrix3Xd referencePoints(const spline::UniformBSpline& r,
                                               const Eigen::VectorXd& along);

}  // namespace slalom::global_planner
