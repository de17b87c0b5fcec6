// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

namespace slalom::spline
{
/** Uniform cubic B-spline in R^3 over time; the form of every reference in Slalom.
 *
 *  n control points and the knot span D give n - 3 polynomial spans over [start, start + (n - 3)
 * D]. On span i with u in [0, 1): p = 1/6 [1 u u^2 u^3] M [c_i .. c_i+3], a convex combination of
 * four control points. Evaluation clamps the time to [start, end]; derivatives are exact.
 * Immutable; thread-safe.
 *  @see [Paper Sec. III-A], docs/paper_map.md. */
class UniformBSpline
{
 public:
  static constexpr int kDegree = 3;

  /** @param control_points 3xN, one per column [m], N >= 4
   *  @param knot_span D [s], > 0
   *  @param start time of the first knot of the domain [s]
   *  @throws std::invalid_argument on fewer than 4 points, a non-positive span or non-finite
   * numbers */
  UniformBSpline(Eigen::Matrix3Xd control_points, double knot_span, double start = 0.0);

  [[nodiscard]] const Eigen::Matrix3Xd& controlPoints() const { return control_points_; }
  [[nodiscard]] Eigen::Index size() const { return control_points_.cols(); }
  [[nodiscard]] Eigen::Index spans() const { return size() - kDegree; }
  [[nodiscard]] double knotSpan() const { return knot_span_; }
  [[nodiscard]] double start() const { return start_; }
  [[nodiscard]] double end() const { return start_ + knot_span_ * static_cast<double>(spans()); }
  [[nodiscard]] double duration() const { return end() - start_; }

  [[nodiscard]] Eigen::Vector3d position(double t) const;      ///< [m]
  [[nodiscard]] Eigen::Vector3d velocity(double t) const;      ///< [m/s]
  [[nodiscard]] Eigen::Vector3d acceleration(double t) const;  ///< [m/s^2]
  [[nodiscard]] Eigen::Vector3d jerk(double t) const;          ///< [m/s^3], piecewise constant

  /// Index i of the span that holds t, in [0, spans()-1]; its control points are i .. i+3.
  [[nodiscard]] Eigen::Index spanAt(double t) const;

  /// Control points of the first derivative, 3x(N-1) [m/s]; the curve's velocity lies in their
  /// hulls.
  [[nodiscard]] Eigen::Matrix3Xd velocityControlPoints() const;
  /// Control points of the second derivative, 3x(N-2) [m/s^2].
  [[nodiscard]] Eigen::Matrix3Xd accelerationControlPoints() const;

  /// Same knots, other control points.
  [[nodiscard]] UniformBSpline withControlPoints(Eigen::Matrix3Xd control_points) const;

  /// Time in [from, to] at which the curve is nearest to p (coarse scan of the spans, then Newton).
  /// [s]
  [[nodiscard]] double project(const Eigen::Vector3d& p, double from, double to) const;

  /// Arc length between two times [m], Gauss-Legendre per span.
  [[nodiscard]] double length(double from, double to) const;

  /// Points at `count` >= 2 equidistant times in [from, to], 3xcount.
  [[nodiscard]] Eigen::Matrix3Xd sample(double from, double to, Eigen::Index count) const;

 private:
  Eigen::Matrix3Xd control_points_;
  double knot_span_;
  double start_;
};

}  // namespace slalom::spline
