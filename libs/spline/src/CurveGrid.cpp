// SPDX-License-Identifier: BSD-3-Clause
#include "CurveGrid.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace slalom::spline::detail
{
namespace
{
constexpr Eigen::Index kCells = 4;  ///< intervals per knot span

/// One axis of the curve on one interval: derivatives at its start, where the jerk is constant.
struct Axis
{
  double v, a, j;
};

Axis axisAt(const UniformBSpline& curve, Eigen::Index span, int axis, double since_knot)
{
  const double d = curve.knotSpan(), s = since_knot;
  const auto c = [&](Eigen::Index i) { return curve.controlPoints()(axis, span + i); };
  const double before = c(1) - c(0), middle = c(2) - c(1), after = c(3) - c(2);
  const double v = 0.5 * (before + middle) / d, a = (middle - before) / (d * d);
  const double j = (after - 2.0 * middle + before) / (d * d * d);
  return {v + s * (a + 0.5 * s * j), a + s * j, j};
}

/** With v, a at the start and s the way from there, the acceleration of the motion is
 * (a x + v w) + s (j x + 3 a w) + s^2 5/2 j w; its three Bernstein coefficients bound it. */
void limitAcceleration(const Axis& p, double limit, IntervalLimits& limits)
{
  const double h = limits.step();
  limits.limitAcceleration(p.v, p.a, limit);
  limits.limitAcceleration(p.v + 1.5 * h * p.a, p.a + 0.5 * h * p.j, limit);
  limits.limitAcceleration(p.v + h * (3.0 * p.a + 2.5 * h * p.j), p.a + h * p.j, limit);
}

/** With |v| below the quadratic of coefficients b, v^2 x lies below a quintic; the outer two of its
 * Bernstein coefficients are caps on x, the inner four are linear in x and w. */
void limitSpeed(const Axis& p, double limit, IntervalLimits& limits)
{
  constexpr double kSmallest = 1e-3;  // keeps the factors of w away from 0
  const double h = limits.step(), squared = limit * limit;
  std::array<double, 3> b = {std::abs(p.v), std::abs(p.v + 0.5 * h * p.a),
                             std::abs(p.v + h * (p.a + 0.5 * h * p.j))};
  const double largest = std::max({b[0], b[1], b[2]});
  if (largest <= limit) return;  // pace <= 1 is enough
  for (double& coefficient : b) coefficient = std::max(coefficient, kSmallest * largest);
  const std::array<double, 5> square = {
      b[0] * b[0], b[0] * b[1], (b[0] * b[2] + 2.0 * b[1] * b[1]) / 3.0, b[1] * b[2], b[2] * b[2]};
  limits.capSpeed(squared / square.front(), squared / square.back());
  for (std::size_t k = 1; k < 5; ++k)
  {
    const double at_end = 0.2 * static_cast<double>(k) * square[k - 1];
    const double at_start = 0.2 * static_cast<double>(5 - k) * square[k];
    limits.limitSpeed(2.0 * h * at_end, at_start + at_end, squared);
  }
}

/// Limits from `since_knot` after the first knot of a span on, over a length h within the span.
IntervalLimits limitsOn(const UniformBSpline& curve, Eigen::Index span, double since_knot, double h,
                        const MotionLimits& limits)
{
  constexpr double kNegligible = 1e-9;  // of the acceleration limit, as |w| <= 1 / (2 h)
  constexpr double kFastest = 1.0;      // pace
  IntervalLimits interval(h, kNegligible * 2.0 * h * limits.acceleration_mps2, kFastest);
  for (int axis = 0; axis < 3; ++axis)
  {
    const Axis p = axisAt(curve, span, axis, since_knot);
    limitAcceleration(p, limits.acceleration_mps2, interval);
    limitSpeed(p, limits.speed_mps, interval);
  }
  return interval;
}

struct Cells
{
  Eigen::Index first, last;
  Eigen::Index parts;  ///< intervals per cell
};

/// Rest to rest takes two intervals at least; a short stretch is cut finer.
Cells cellsOf(const UniformBSpline& curve, double from, double to)
{
  constexpr double kSliver = 1e-6;  // of a cell: a shorter one joins its neighbour
  constexpr Eigen::Index kFewest = 4;
  const double cell = curve.knotSpan() / static_cast<double>(kCells);
  const Eigen::Index last_cell = kCells * curve.spans() - 1;
  const auto cellAt = [&](double cells)
  { return std::clamp(static_cast<Eigen::Index>(cells), Eigen::Index{0}, last_cell); };
  const Eigen::Index first = cellAt((from - curve.start()) / cell + kSliver);
  const Eigen::Index last =
      std::max(first, cellAt(std::ceil((to - curve.start()) / cell - kSliver) - 1.0));
  return {first, last, (kFewest + last - first) / (last - first + 1)};
}
}  // namespace

CurveGrid makeGrid(const UniformBSpline& curve, double from, double to, const MotionLimits& limits,
                   std::span<const double> span_speeds)
{
  constexpr double kKeptShare = 0.25;  // of what braking at one acceleration to the end leaves
  const Cells cells = cellsOf(curve, from, to);
  const double d = curve.knotSpan(), cell = d / static_cast<double>(kCells);
  const auto count = static_cast<std::size_t>(cells.parts * (cells.last - cells.first + 1));
  CurveGrid grid;
  grid.times.reserve(count + 1);
  grid.intervals.reserve(count);
  grid.times.push_back(from);
  for (Eigen::Index k = cells.first; k <= cells.last; ++k)
  {
    const Eigen::Index span = k / kCells;
    MotionLimits here = limits;
    if (!span_speeds.empty())
      here.speed_mps = std::min(here.speed_mps, span_speeds[static_cast<std::size_t>(span)]);
    const double begin = grid.times.back();
    const double end = k == cells.last ? to : curve.start() + cell * static_cast<double>(k + 1);
    const double h = (end - begin) / static_cast<double>(cells.parts);
    for (Eigen::Index part = 0; part < cells.parts; ++part)
    {
      const double since_begin = h * static_cast<double>(part);
      const double t = begin + since_begin, next = part + 1 == cells.parts ? end : t + h;
      const double since_knot = begin - curve.start() - d * static_cast<double>(span) + since_begin;
      grid.intervals.push_back(limitsOn(curve, span, since_knot, h, here));
      grid.intervals.back().keepShare(kKeptShare * (to - next) / (to - t));
      grid.times.push_back(next);
    }
  }
  return grid;
}

}  // namespace slalom::spline::detail
