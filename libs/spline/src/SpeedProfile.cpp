// SPDX-License-Identifier: BSD-3-Clause
#include "SpeedProfile.h"

#include <algorithm>
#include <cmath>

#include "Reachability.h"

namespace slalom::spline::detail
{
namespace
{
double speedLimit(const PathPiece& piece, double q, double max_speed)
{
  constexpr double kUnbounded = 1e12;
  const double fastest_axis = piece.first(q).cwiseAbs().maxCoeff();
  return fastest_axis < 1e-9 ? kUnbounded : std::pow(max_speed / fastest_axis, 2);
}

/// Limits hold at both ends of the interval, where x differs by 2 w step.
IntervalLimits limitsOn(const PathPiece& piece, double q, double step, double max_speed,
                        double max_acceleration)
{
  constexpr double kNegligible = 1e-9;
  IntervalLimits limits(step, kNegligible);
  const Eigen::Vector3d first0 = piece.first(q), second0 = piece.second(q);
  const Eigen::Vector3d first1 = piece.first(q + step), second1 = piece.second(q + step);
  for (int axis = 0; axis < 3; ++axis)
  {
    limits.limitAcceleration(first0[axis], second0[axis], max_acceleration);
    limits.limitAcceleration(first1[axis] + 2.0 * step * second1[axis], second1[axis],
                             max_acceleration);
  }
  limits.capSpeed(speedLimit(piece, q, max_speed), speedLimit(piece, q + step, max_speed));
  return limits;
}
}  // namespace

SpeedProfile::SpeedProfile(const std::vector<PathPiece>& pieces, double max_speed,
                           double max_acceleration)
    : pieces_(pieces)
{
  makeGrid();
  std::vector<IntervalLimits> intervals;
  intervals.reserve(nodes_.size());
  for (std::size_t i = 0; i + 1 < nodes_.size(); ++i)
    intervals.push_back(limitsOn(pieces_[nodes_[i].piece], nodes_[i].q, nodes_[i].step, max_speed,
                                 max_acceleration));
  const std::vector<double> x = fastest(intervals, controllable(intervals, 0.0), 0.0);
  for (std::size_t i = 0; i < nodes_.size(); ++i) nodes_[i].x = x[i];
  for (std::size_t i = 0; i + 1 < nodes_.size(); ++i)
    nodes_[i + 1].t = nodes_[i].t + passageTime(x[i], x[i + 1], nodes_[i].step);
}

void SpeedProfile::makeGrid()
{
  constexpr double kStep = 0.05, kCoarse = 1.0;  // [m]
  constexpr double kFewest = 40.0;
  // Along a straight piece the limits are the same everywhere.
  const auto straight = [](const PathPiece& p)
  {
    constexpr double kSame = 1e-9;
    return (p.d0 - p.d1).norm() < kSame && (p.d0 - (p.p1 - p.p0) / p.extent).norm() < kSame;
  };
  constexpr double kLong = 500.0, kEnds = 200.0;  // [m]
  const auto cut = [this](std::size_t k, double from, double length, double count)
  {
    for (double i = 0.0; i < count; ++i)
      nodes_.push_back({k, from + length * i / count, length / count});
  };
  for (std::size_t k = 0; k < pieces_.size(); ++k)
  {
    const double extent = pieces_[k].extent, middle = extent - 2.0 * kEnds;
    if (extent <= kLong || !straight(pieces_[k]))
    {
      cut(k, 0.0, extent, std::max(kFewest, std::ceil(extent / kStep)));
      continue;
    }
    cut(k, 0.0, kEnds, kEnds / kStep);
    cut(k, kEnds, middle, std::ceil(middle / kCoarse));
    cut(k, kEnds + middle, kEnds, kEnds / kStep);
  }
  nodes_.push_back({pieces_.size() - 1, pieces_.back().extent, 0.0});
}

Eigen::Vector3d SpeedProfile::position(double t) const
{
  if (!(t > 0.0)) return pieces_.front().p0;
  if (t >= duration()) return pieces_.back().p1;
  const auto after = std::upper_bound(nodes_.begin(), nodes_.end(), t,
                                      [](double time, const Node& node) { return time < node.t; });
  const Node& node = *(after - 1);
  const double q = node.q + passageDistance(node.x, after->x, node.step, t - node.t);
  return pieces_[node.piece].position(q);
}

}  // namespace slalom::spline::detail
