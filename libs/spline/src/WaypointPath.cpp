// SPDX-License-Identifier: BSD-3-Clause
#include "WaypointPath.h"

#include <algorithm>
#include <cmath>

namespace slalom::spline::detail
{
Eigen::Vector3d PathPiece::position(double q) const
{
  const double u = q / extent, v = 1.0 - u;
  return p0 * (v * v * (1.0 + 2.0 * u)) + p1 * (u * u * (3.0 - 2.0 * u)) +
         extent * (u * v) * (v * d0 - u * d1);
}

Eigen::Vector3d PathPiece::first(double q) const
{
  const double u = q / extent, v = 1.0 - u;
  return 6.0 * u * v * (p1 - p0) / extent + v * (v - 2.0 * u) * d0 + u * (u - 2.0 * v) * d1;
}

Eigen::Vector3d PathPiece::second(double q) const
{
  const double u = q / extent;
  return ((6.0 - 12.0 * u) * (p1 - p0) / extent + (6.0 * u - 4.0) * d0 + (6.0 * u - 2.0) * d1) /
         extent;
}

namespace
{
/// Tangents at the waypoints; those at both ends are left to the pieces there.
Eigen::Matrix3Xd cornerTangents(const Eigen::Matrix3Xd& directions)
{
  // Sharper turns than this (cosine of half the angle) are taken at rest: the loop that a through
  // tangent makes there is slower than stopping.
  constexpr double kSharpest = 0.25;
  const Eigen::Index corners = directions.cols() - 1;
  Eigen::Matrix3Xd tangents = Eigen::Matrix3Xd::Zero(3, corners + 2);
  for (Eigen::Index i = 0; i < corners; ++i)
  {
    const Eigen::Vector3d mean = 0.5 * (directions.col(i) + directions.col(i + 1));
    if (mean.norm() > kSharpest) tangents.col(i + 1) = mean;
  }
  return tangents;
}

/// A piece from or to an end of the path: no bend there ("natural").
void makeNatural(PathPiece& piece, bool at_start, bool at_end)
{
  const Eigen::Vector3d slope = (piece.p1 - piece.p0) / piece.extent;
  if (at_start && at_end)
    piece.d0 = piece.d1 = slope;
  else if (at_start)
    piece.d0 = 1.5 * slope - 0.5 * piece.d1;
  else if (at_end)
    piece.d1 = 1.5 * slope - 0.5 * piece.d0;
}
}  // namespace

std::vector<PathPiece> pathThrough(const Eigen::Matrix3Xd& waypoints, double corner_reach)
{
  constexpr double kOtherLegs = 2.0;
  const Eigen::Index legs = waypoints.cols() - 1;
  Eigen::Matrix3Xd directions = waypoints.rightCols(legs) - waypoints.leftCols(legs);
  const Eigen::RowVectorXd length = directions.colwise().norm();
  directions.array().rowwise() /= length.array();
  const Eigen::Matrix3Xd tangents = cornerTangents(directions);

  std::vector<PathPiece> pieces;
  pieces.reserve(static_cast<std::size_t>(3 * legs));
  for (Eigen::Index k = 0; k < legs; ++k)
  {
    const bool first = k == 0, last = k == legs - 1;
    const double before = first ? 0.0 : std::min(corner_reach, kOtherLegs * length[k - 1]);
    const double after = last ? 0.0 : std::min(corner_reach, kOtherLegs * length[k + 1]);
    const Eigen::Vector3d a = waypoints.col(k), b = waypoints.col(k + 1), along = directions.col(k);
    if (before + after >= length[k] || (first && last))
    {
      pieces.push_back({a, b, tangents.col(k), tangents.col(k + 1), length[k]});
      makeNatural(pieces.back(), first, last);
      continue;
    }
    const Eigen::Vector3d in = a + before * along, out = b - after * along;
    if (before > 0.0) pieces.push_back({a, in, tangents.col(k), along, before});
    pieces.push_back({in, out, along, along, length[k] - before - after});
    if (after > 0.0) pieces.push_back({out, b, along, tangents.col(k + 1), after});
  }
  return pieces;
}

}  // namespace slalom::spline::detail
