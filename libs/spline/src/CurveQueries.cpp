// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <string>

#include "slalom/spline/UniformBSpline.h"

namespace slalom::spline
{
namespace
{
constexpr int kScanSteps = 8;  ///< scan points per knot span
constexpr int kNewtonSteps = 20;

/// Newton on the squared distance, kept in [lo, hi]; halves a step that does not come nearer.
double nearestLocally(const UniformBSpline& curve, const Eigen::Vector3d& p, double t, double lo,
                      double hi)
{
  double best = (curve.position(t) - p).squaredNorm();
  for (int i = 0; i < kNewtonSteps; ++i)
  {
    const Eigen::Vector3d offset = curve.position(t) - p, v = curve.velocity(t);
    const double slope = offset.dot(v);
    const double bend = v.squaredNorm() + offset.dot(curve.acceleration(t));
    // Where the distance is concave, Newton would climb: go downhill by a Gauss-Newton step.
    const double curvature = bend > 0.0 ? bend : v.squaredNorm();
    if (!(curvature > 0.0)) break;
    double step = -slope / curvature;
    bool moved = false;
    for (int halving = 0; halving < 20 && !moved; ++halving, step *= 0.5)
    {
      const double next = std::clamp(t + step, lo, hi);
      const double distance = (curve.position(next) - p).squaredNorm();
      if (next == t || !(distance < best)) continue;
      t = next;
      best = distance;
      moved = true;
    }
    if (!moved) break;
  }
  return t;
}

/// Largest speed on a span: its velocity control points bound it.
double speedBound(const UniformBSpline& curve, Eigen::Index span)
{
  const auto c = curve.controlPoints().middleCols<4>(span);
  return (c.rightCols<3>() - c.leftCols<3>()).colwise().norm().maxCoeff() / curve.knotSpan();
}
}  // namespace

double UniformBSpline::project(const Eigen::Vector3d& p, double from, double to) const
{
  from = std::clamp(from, start(), end());
  to = std::clamp(to, from, end());
  const auto steps =
      std::max<Eigen::Index>(1, std::lround(std::ceil((to - from) / knot_span_ * kScanSteps)));
  const double step = (to - from) / static_cast<double>(steps);
  const auto scanTime = [&](Eigen::Index i)
  { return i == steps ? to : from + step * static_cast<double>(i); };

  Eigen::VectorXd distance(steps + 1);
  for (Eigen::Index i = 0; i <= steps; ++i) distance[i] = (position(scanTime(i)) - p).norm();

  // Between two scan points the curve can come nearer by at most speed x time / 2, so only
  // intervals that could still win are refined; the result does not depend on which one looked
  // best.
  Eigen::Index first_best = 0;
  double best = distance.minCoeff(&first_best);
  double best_t = scanTime(first_best);
  for (Eigen::Index i = 0; i < steps; ++i)
  {
    const double lo = scanTime(i), hi = scanTime(i + 1);
    const double speed = std::max(speedBound(*this, spanAt(lo)), speedBound(*this, spanAt(hi)));
    if (0.5 * (distance[i] + distance[i + 1] - speed * step) > best) continue;
    const double guess = distance[i] <= distance[i + 1] ? lo : hi;
    const double t = nearestLocally(*this, p, guess, lo, hi);
    const double d = (position(t) - p).norm();
    if (d < best)
    {
      best = d;
      best_t = t;
    }
  }
  return best_t;
}

double UniformBSpline::length(double from, double to) const
{
  constexpr std::array<double, 3> kNodes = {0.0, 0.5384693101056831, 0.9061798459386640};
  constexpr std::array<double, 3> kWeights = {0.5688888888888889, 0.4786286704993665,
                                              0.2369268850561891};
  from = std::clamp(from, start(), end());
  to = std::clamp(to, from, end());
  double sum = 0.0;
  const Eigen::Index last = spanAt(to);
  for (Eigen::Index span = spanAt(from); span <= last; ++span)
  {
    const double knot = start_ + knot_span_ * static_cast<double>(span);
    const double lo = std::max(from, knot), hi = std::min(to, knot + knot_span_);
    if (!(hi > lo)) continue;
    const double mid = 0.5 * (lo + hi), half = 0.5 * (hi - lo);
    double speed = kWeights[0] * velocity(mid).norm();
    for (std::size_t k = 1; k < kNodes.size(); ++k)
      speed += kWeights[k] *
               (velocity(mid - half * kNodes[k]).norm() + velocity(mid + half * kNodes[k]).norm());
    sum += half * speed;
  }
  return sum;
}

Eigen::Matrix3Xd UniformBSpline::sample(double from, double to, Eigen::Index count) const
{
  if (count < 2)
    throw std::invalid_argument("UniformBSpline::sample: count " + std::to_string(count) +
                                ", at least 2 needed");
  Eigen::Matrix3Xd points(3, count);
  for (Eigen::Index i = 0; i < count; ++i)
  {
    const double part = static_cast<double>(i) / static_cast<double>(count - 1);
    points.col(i) = position(from + (to - from) * part);
  }
  return points;
}

}  // namespace slalom::spline
