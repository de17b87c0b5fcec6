// SPDX-License-Identifier: BSD-3-Clause
#include "slalom/spline/UniformBSpline.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

namespace slalom::spline
{
namespace
{
using Weights = Eigen::Vector4d;

Weights positionWeights(double u)
{
  const double v = 1.0 - u, u2 = u * u, u3 = u2 * u;
  return Weights(v * v * v, 3.0 * u3 - 6.0 * u2 + 4.0, -3.0 * u3 + 3.0 * u2 + 3.0 * u + 1.0, u3) /
         6.0;
}
Weights velocityWeights(double u)
{
  const double v = 1.0 - u, u2 = u * u;
  return 0.5 * Weights(-v * v, 3.0 * u2 - 4.0 * u, -3.0 * u2 + 2.0 * u + 1.0, u2);
}
Weights accelerationWeights(double u)
{
  return {1.0 - u, 3.0 * u - 2.0, -3.0 * u + 1.0, u};
}
Weights jerkWeights()
{
  return {-1.0, 3.0, -3.0, 1.0};
}

/// Place of a time in its span, in [0, 1].
double localParameter(const UniformBSpline& curve, double t, Eigen::Index span)
{
  if (t >= curve.end()) return 1.0;
  const double u = (t - curve.start()) / curve.knotSpan() - static_cast<double>(span);
  return u > 0.0 ? std::min(u, 1.0) : 0.0;
}
}  // namespace

UniformBSpline::UniformBSpline(Eigen::Matrix3Xd control_points, double knot_span, double start)
    : control_points_(std::move(control_points)), knot_span_(knot_span), start_(start)
{
  if (size() < kDegree + 1)
    throw std::invalid_argument("UniformBSpline: " + std::to_string(size()) +
                                " control points, at least 4 needed");
  if (!(knot_span_ > 0.0) || !std::isfinite(knot_span_))
    throw std::invalid_argument("UniformBSpline: knot span " + std::to_string(knot_span_) +
                                " s, must be positive and finite");
  if (!control_points_.allFinite() || !std::isfinite(start_))
    throw std::invalid_argument("UniformBSpline: a control point or the start time is not finite");
}

Eigen::Index UniformBSpline::spanAt(double t) const
{
  const double spans_before = std::floor((t - start_) / knot_span_);
  if (!(spans_before > 0.0)) return 0;
  const Eigen::Index last = spans() - 1;
  return spans_before >= static_cast<double>(last) ? last : static_cast<Eigen::Index>(spans_before);
}

Eigen::Vector3d UniformBSpline::position(double t) const
{
  const Eigen::Index i = spanAt(t);
  return control_points_.middleCols<4>(i) * positionWeights(localParameter(*this, t, i));
}

Eigen::Vector3d UniformBSpline::velocity(double t) const
{
  const Eigen::Index i = spanAt(t);
  return control_points_.middleCols<4>(i) * velocityWeights(localParameter(*this, t, i)) /
         knot_span_;
}

Eigen::Vector3d UniformBSpline::acceleration(double t) const
{
  const Eigen::Index i = spanAt(t);
  return control_points_.middleCols<4>(i) * accelerationWeights(localParameter(*this, t, i)) /
         (knot_span_ * knot_span_);
}

Eigen::Vector3d UniformBSpline::jerk(double t) const
{
  return control_points_.middleCols<4>(spanAt(t)) * jerkWeights() /
         (knot_span_ * knot_span_ * knot_span_);
}

Eigen::Matrix3Xd UniformBSpline::velocityControlPoints() const
{
  const Eigen::Index n = size() - 1;
  return (control_points_.rightCols(n) - control_points_.leftCols(n)) / knot_span_;
}

Eigen::Matrix3Xd UniformBSpline::accelerationControlPoints() const
{
  const Eigen::Index n = size() - 2;
  return (control_points_.rightCols(n) - 2.0 * control_points_.middleCols(1, n) +
          control_points_.leftCols(n)) /
         (knot_span_ * knot_span_);
}

UniformBSpline UniformBSpline::withControlPoints(Eigen::Matrix3Xd control_points) const
{
  if (control_points.cols() != size())
    throw std::invalid_argument("UniformBSpline: " + std::to_string(control_points.cols()) +
                                " control points for a spline of " + std::to_string(size()));
  return {std::move(control_points), knot_span_, start_};
}

}  // namespace slalom::spline
