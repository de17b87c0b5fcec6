// SPDX-License-Identifier: BSD-3-Clause
#include "slalom/spline/TimeLaw.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

#include "CurveGrid.h"
#include "Reachability.h"

namespace slalom::spline
{
namespace
{
constexpr double kRest = 1e-4;  ///< share of the speed limit that counts as rest

void check(double from, double to, double start_pace, const MotionLimits& limits)
{
  const auto require = [](bool holds, double value, const char* name)
  {
    if (!holds || !std::isfinite(value))
      throw std::invalid_argument(std::string("TimeLaw: ") + name + " = " + std::to_string(value));
  };
  require(limits.speed_mps > 0.0, limits.speed_mps, "speed limit");
  require(limits.acceleration_mps2 > 0.0, limits.acceleration_mps2, "acceleration limit");
  require(true, from, "from");
  require(true, to, "to");
  require(true, start_pace, "start_pace");
}

bool isAtRest(const UniformBSpline& curve, double t, const MotionLimits& limits)
{
  return curve.velocity(t).cwiseAbs().maxCoeff() <= kRest * limits.speed_mps;
}
}  // namespace

TimeLaw::TimeLaw(const UniformBSpline& curve, double from, double to, double start_pace,
                 const MotionLimits& limits, std::span<const double> span_speeds)
{
  check(from, to, start_pace, limits);
  if (!span_speeds.empty() && (static_cast<Eigen::Index>(span_speeds.size()) != curve.spans() ||
                               !std::ranges::all_of(span_speeds, [](double v) { return v > 0.0; })))
    throw std::invalid_argument("TimeLaw: span speeds must be positive, one for each span");
  from = std::clamp(from, curve.start(), curve.end());
  to = std::clamp(to, from, curve.end());
  const bool free_start = isAtRest(curve, from, limits);
  const double x_end = isAtRest(curve, to, limits) ? 1.0 : 0.0;
  const double x_wanted = std::pow(std::clamp(start_pace, 0.0, 1.0), 2);
  const double resolution = 16.0 * std::numeric_limits<double>::epsilon() *
                            std::max({std::abs(from), std::abs(to), curve.knotSpan()});
  if (to - from <= resolution)
  {
    nodes_.push_back({to, x_end, 0.0});
    if (!free_start && x_wanted > 0.0) excess_ = std::numeric_limits<double>::infinity();
    return;
  }

  constexpr double kNear = 1.0 + 1e-4;  // half of that is a jump in speed nobody sees
  const detail::CurveGrid grid = detail::makeGrid(curve, from, to, limits, span_speeds);
  const std::vector<double> reachable = detail::controllable(grid.intervals, x_end);
  for (const double t : grid.times) nodes_.push_back({t, 0.0, 0.0});
  if (free_start || x_wanted <= kNear * reachable.front())
  {
    const double x_start = free_start ? reachable.front() : std::min(x_wanted, reachable.front());
    makeNodes(detail::fastest(grid.intervals, reachable, x_start));
    return;
  }
  const detail::Braking braking = detail::brake(grid.intervals, reachable, x_wanted);
  excess_ = braking.ratio - 1.0;
  makeNodes(braking.x);
}

void TimeLaw::makeNodes(const std::vector<double>& x)
{
  for (std::size_t i = 0; i < nodes_.size(); ++i) nodes_[i].x = x[i];
  for (std::size_t i = 1; i < nodes_.size(); ++i)
    nodes_[i].tau =
        nodes_[i - 1].tau + detail::passageTime(x[i - 1], x[i], nodes_[i].t - nodes_[i - 1].t);
}

std::size_t TimeLaw::intervalAt(double t) const
{
  const auto after = std::upper_bound(nodes_.begin() + 1, nodes_.end() - 1, t,
                                      [](double time, const Node& node) { return time < node.t; });
  return static_cast<std::size_t>(after - nodes_.begin()) - 1;
}

double TimeLaw::squaredPace(std::size_t interval, double t) const
{
  // Not x + slope (t - start): near a stop that would be the difference of equal numbers.
  const Node &a = nodes_[interval], &b = nodes_[interval + 1];
  return (a.x * (b.t - t) + b.x * (t - a.t)) / (b.t - a.t);
}

double TimeLaw::pace(double t) const
{
  if (nodes_.size() == 1) return std::sqrt(nodes_.front().x);
  t = std::clamp(t, from(), to());
  return std::sqrt(squaredPace(intervalAt(t), t));
}

double TimeLaw::paceChange(double t) const
{
  if (nodes_.size() == 1 || t >= to()) return 0.0;
  const std::size_t i = intervalAt(std::max(t, from()));
  return 0.5 * (nodes_[i + 1].x - nodes_[i].x) / (nodes_[i + 1].t - nodes_[i].t);
}

double TimeLaw::advance(double t, double dt) const
{
  t = std::clamp(t, from(), to());
  if (!(dt > 0.0) || t == to()) return t;
  const std::size_t i = intervalAt(t);
  const double tau =
      nodes_[i].tau + detail::passageTime(nodes_[i].x, squaredPace(i, t), t - nodes_[i].t) + dt;
  if (tau >= duration()) return to();
  const auto after =
      std::upper_bound(nodes_.begin(), nodes_.end(), tau,
                       [](double time, const Node& node) { return time < node.tau; });
  const Node &a = *(after - 1), &b = *after;
  return std::max(t, a.t + detail::passageDistance(a.x, b.x, b.t - a.t, tau - a.tau));
}

}  // namespace slalom::spline
