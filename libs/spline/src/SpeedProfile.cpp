// SPDX-License-Identifier: BSD-3-Clause
#include "SpeedProfile.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace slalom::spline::detail
{
namespace
{
constexpr double kUnbounded = 1e12;

/// Bounds on w that are linear in x: w >= offset + slope x, or w <= offset + slope x.
struct Line
{
  double offset, slope;
  [[nodiscard]] double at(double x) const { return offset + slope * x; }
};

/// All limits of one grid interval: lower and upper lines on w, and one bound on x.
struct IntervalLimits
{
  std::array<Line, 7> lower, upper;
  int lowers = 0, uppers = 0;
  double x_max = kUnbounded;

  /// |along w + bend x| <= limit.
  void add(double along, double bend, double limit)
  {
    if (std::abs(along) < 1e-9)
    {
      if (std::abs(bend) > 1e-12) x_max = std::min(x_max, limit / std::abs(bend));
      return;
    }
    const double reach = limit / std::abs(along), slope = -bend / along;
    lower[lowers++] = {-reach, slope};
    upper[uppers++] = {reach, slope};
  }
  [[nodiscard]] double smallest(double x) const
  {
    double w = -kUnbounded;
    for (int i = 0; i < lowers; ++i) w = std::max(w, lower[i].at(x));
    return w;
  }
  [[nodiscard]] double largest(double x) const
  {
    double w = kUnbounded;
    for (int i = 0; i < uppers; ++i) w = std::min(w, upper[i].at(x));
    return w;
  }
  /// Largest x >= 0 for which some w satisfies every line. x = 0 does, so each pair gives a bound.
  [[nodiscard]] double largestX() const
  {
    double x = x_max;
    for (int i = 0; i < lowers; ++i)
      for (int j = 0; j < uppers; ++j)
      {
        const double closing = lower[i].slope - upper[j].slope;
        if (closing > 1e-15)
          x = std::min(x, std::max(0.0, upper[j].offset - lower[i].offset) / closing);
      }
    return x;
  }
};

/// Acceleration limits hold at both ends of the interval, where x differs by 2 w step.
IntervalLimits limitsOn(const PathPiece& piece, double q, double step, double max_acceleration)
{
  IntervalLimits limits;
  const Eigen::Vector3d first0 = piece.first(q), second0 = piece.second(q);
  const Eigen::Vector3d first1 = piece.first(q + step), second1 = piece.second(q + step);
  for (int axis = 0; axis < 3; ++axis)
  {
    limits.add(first0[axis], second0[axis], max_acceleration);
    limits.add(first1[axis] + 2.0 * step * second1[axis], second1[axis], max_acceleration);
  }
  return limits;
}

double speedLimit(const PathPiece& piece, double q, double max_speed)
{
  const double fastest_axis = piece.first(q).cwiseAbs().maxCoeff();
  return fastest_axis < 1e-9 ? kUnbounded : std::pow(max_speed / fastest_axis, 2);
}
}  // namespace

SpeedProfile::SpeedProfile(const std::vector<PathPiece>& pieces, double max_speed,
                           double max_acceleration)
    : pieces_(pieces)
{
  makeGrid();
  passBackward(max_speed, max_acceleration);
  passForward(max_acceleration);
  makeTimes();
}

void SpeedProfile::makeGrid()
{
  constexpr double kStep = 0.05;  // [m]
  constexpr double kFewest = 40.0;
  for (std::size_t k = 0; k < pieces_.size(); ++k)
  {
    const double extent = pieces_[k].extent;
    const double count = std::max(kFewest, std::ceil(extent / kStep));
    for (double i = 0.0; i < count; ++i) nodes_.push_back({k, extent * i / count, extent / count});
  }
  nodes_.push_back({pieces_.size() - 1, pieces_.back().extent, 0.0});
}

void SpeedProfile::passBackward(double max_speed, double max_acceleration)
{
  reachable_.assign(nodes_.size(), 0.0);
  for (std::size_t i = nodes_.size() - 1; i-- > 0;)
  {
    const Node& node = nodes_[i];
    const PathPiece& piece = pieces_[node.piece];
    IntervalLimits limits = limitsOn(piece, node.q, node.step, max_acceleration);
    limits.x_max = std::min(limits.x_max, speedLimit(piece, node.q, max_speed));
    const double next =
        std::min(reachable_[i + 1], speedLimit(piece, node.q + node.step, max_speed));
    limits.lower[limits.lowers++] = {0.0, -0.5 / node.step};
    limits.upper[limits.uppers++] = {0.5 * next / node.step, -0.5 / node.step};
    reachable_[i] = limits.largestX();
    // The speed limit at the end of this interval binds the next node too (left derivative).
    reachable_[i + 1] = next;
  }
}

void SpeedProfile::passForward(double max_acceleration)
{
  nodes_.front().x = 0.0;
  for (std::size_t i = 0; i + 1 < nodes_.size(); ++i)
  {
    const Node& node = nodes_[i];
    const IntervalLimits limits =
        limitsOn(pieces_[node.piece], node.q, node.step, max_acceleration);
    const double w =
        std::max(limits.smallest(node.x),
                 std::min(limits.largest(node.x), 0.5 * (reachable_[i + 1] - node.x) / node.step));
    nodes_[i + 1].x = std::clamp(node.x + 2.0 * node.step * w, 0.0, reachable_[i + 1]);
  }
}

void SpeedProfile::makeTimes()
{
  for (std::size_t i = 0; i + 1 < nodes_.size(); ++i)
  {
    const double sum = std::sqrt(nodes_[i].x) + std::sqrt(nodes_[i + 1].x);
    nodes_[i + 1].t = nodes_[i].t + 2.0 * nodes_[i].step / std::max(sum, 1e-9);
  }
}

Eigen::Vector3d SpeedProfile::position(double t) const
{
  if (!(t > 0.0)) return pieces_.front().p0;
  if (t >= duration()) return pieces_.back().p1;
  const auto after = std::upper_bound(nodes_.begin(), nodes_.end(), t,
                                      [](double time, const Node& node) { return time < node.t; });
  const Node& node = *(after - 1);
  const double tau = t - node.t, span = after->t - node.t;
  const double rate = std::sqrt(node.x), rate_change = (std::sqrt(after->x) - rate) / span;
  const double q = node.q + std::min(node.step, tau * (rate + 0.5 * rate_change * tau));
  return pieces_[node.piece].position(q);
}

}  // namespace slalom::spline::detail
