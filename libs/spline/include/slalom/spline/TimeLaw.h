// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "slalom/spline/UniformBSpline.h"

namespace slalom::spline
{
/// Limits of a motion, per axis.
struct MotionLimits
{
  double speed_mps;          ///< [m/s] > 0
  double acceleration_mps2;  ///< [m/s^2] > 0
};

/** How fast the parameter t of a curve runs in time tau: pace = dt/dtau in [0, 1].
 *
 *  The motion has velocity c'(t) pace and acceleration c''(t) pace^2 + c'(t) paceChange. The law is
 * the fastest one with pace <= 1 (the curve's own timing is the wish) that keeps the limits and
 * comes to rest at its end. The pace change is constant on quarters of knot spans, where the
 * acceleration is a quadratic in t whose Bernstein coefficients keep the limit: it holds between
 * the grid points too. Above 0 everywhere between `from` and `to`.
 *
 *  Where the curve itself is at rest (its velocity is below 1e-4 of the limit on every axis) the
 * pace moves nothing and is free: at `from`, start_pace is ignored and the pace is the fastest
 * possible; at `to`, the pace may be up to 1.
 *
 *  Immutable, a value; thread-safe.
 *  @see Pham and Pham, "A new approach to time-optimal path parameterization based on reachability
 * analysis", 2018; deviation D-10 (docs/paper_map.md) */
class TimeLaw
{
 public:
  /** @param from,to stretch of the curve [s], clamped to its domain; `to` to at least `from`. A
   * stretch of a few roundings is its end.
   *  @param start_pace pace at `from`, clamped to [0, 1]
   *  @param span_speeds lower speed limits for single spans of the curve, as where gaps are tight
   * [m/s]; empty, or one > 0 for each
   *  @throws std::invalid_argument on a limit that is not positive and finite, or a number that is
   * not finite */
  TimeLaw(const UniformBSpline& curve, double from, double to, double start_pace,
          const MotionLimits& limits, std::span<const double> span_speeds = {});

  [[nodiscard]] double from() const { return nodes_.front().t; }  ///< [s] of the curve
  [[nodiscard]] double to() const { return nodes_.back().t; }     ///< [s] of the curve

  /// dt/dtau [1], continuous; t is clamped to [from, to].
  [[nodiscard]] double pace(double t) const;
  /// d2t/dtau2 [1/s]; at a jump, the value after it; 0 from `to` on.
  [[nodiscard]] double paceChange(double t) const;
  /** Parameter dt seconds after it was t [s]: the law in closed form, no integration. `to` is
   * reached in finite time and never passed; t itself for dt <= 0. */
  [[nodiscard]] double advance(double t, double dt) const;
  /// Time from `from` to `to` [s].
  [[nodiscard]] double duration() const { return nodes_.back().tau; }

  /** By what share the motion exceeds its limits because start_pace is too fast to keep them, for
   * example when an obstacle has appeared: largest ratio of an acceleration or a speed to its
   * limit, minus 1. 0 for every other start. The law then brakes by the smallest acceleration that
   * still comes to rest at `to`; infinite where there is no way left to brake on. */
  [[nodiscard]] double excess() const { return excess_; }

 private:
  struct Node
  {
    double t;    ///< parameter
    double x;    ///< pace squared, linear in t up to the next node
    double tau;  ///< time since `from`
  };
  [[nodiscard]] std::size_t intervalAt(double t) const;
  [[nodiscard]] double squaredPace(std::size_t interval, double t) const;
  void makeNodes(const std::vector<double>& x);

  std::vector<Node> nodes_;  ///< at least one
  double excess_ = 0.0;
};

}  // namespace slalom::spline
