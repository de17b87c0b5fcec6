// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "slalom/core/DistanceField.h"
#include "slalom/spline/UniformBSpline.h"

namespace slalom::global_planner
{
/// How far along a curve a clearance is proved, see certify().
struct Certificate
{
  /// [s] the proof covers every point of the curve in [from, until]; `to` if all is proved, `from`
  /// if nothing is.
  double until = 0.0;
  /// [m] lower bound of (distance - required clearance) over [from, until], saturated like the
  /// field; below 0 only if not even the point at `from` is proved clear.
  double margin_m = 0.0;

  /// Whether every point from the start of the proof up to the time `to` [s] is proved clear.
  [[nodiscard]] bool holds(double to) const { return margin_m >= 0.0 && until >= to; }
};

/** Proof that a cubic B-spline keeps a clearance over its whole continuous length.
 *
 *  Claim of the result: every point of the curve at a time in [from, until] is at least
 *  `clearance_m` away (Euclidean) from every obstacle point, where obstacles are the cubes of
 *    UnknownAs::Free      all Occupied voxels; outside the field's bounds() all is free,
 *    UnknownAs::Occupied  all voxels that are not Free, and all space outside bounds().
 *  Between the two a field without voxels has the obstacles that its lowerBound() speaks of.
 *
 *  The curve is bisected into pieces, each enclosed by its Bezier points and their ball, and
 *  accepted on a proved bound of the distance from ball (DistanceField::lowerBound()) or hull
 *  (hullBound()) to the obstacles. No sampling is involved, hence no false accept; the proof is in
 *  Certificate.cpp. A piece is refused only when its ball is below 0.05 mm, so with a field of
 *  voxels a refused curve comes, right behind `until`, nearer to an obstacle than clearance_m +
 *  0.11 mm, unless the work limit was met (20 000 pieces and 64 per span).
 *
 *  @param from,to [s] stretch of the curve; beyond its ends the curve rests at its end points.
 *                 from >= to asks for the point at `from` alone
 *  @param clearance_m [m] > 0, to the voxels' surface: the vehicle's radius and margins
 *  @throws std::invalid_argument on a clearance that is not positive or numbers that are not finite
 *  @see docs/paper_map.md; the paper has no such check. Pure, thread-safe. */
[[nodiscard]] Certificate certify(const spline::UniformBSpline& curve, double from, double to,
                                  const core::DistanceField& field, core::UnknownAs unknown,
                                  double clearance_m);

}  // namespace slalom::global_planner
