// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <vector>

namespace slalom::spline::detail
{
/// Cubic Hermite piece over a parameter range of length `extent` [m], which is its chord.
struct PathPiece
{
  Eigen::Vector3d p0, p1;
  Eigen::Vector3d d0, d1;  ///< derivatives by the parameter at both ends [1], norm <= 1.5
  double extent;

  [[nodiscard]] Eigen::Vector3d position(double q) const;
  [[nodiscard]] Eigen::Vector3d first(double q) const;   ///< dp/dq [1]
  [[nodiscard]] Eigen::Vector3d second(double q) const;  ///< d2p/dq2 [1/m]
};

/** C1 path through every waypoint, straight in the middle of long legs.
 *
 *  The tangent at a corner is the bisector of its legs, scaled by the cosine of half the turn, so a
 * reversal is a point of rest. A corner reaches into a leg by at most `corner_reach` and at most
 * twice the other leg; the path leaves the polyline by at most 0.3 times the shorter leg at the
 * nearer corner.
 *  @param waypoints distinct neighbours, 3xM, M >= 2
 *  @param corner_reach [m] > 0 */
[[nodiscard]] std::vector<PathPiece> pathThrough(const Eigen::Matrix3Xd& waypoints,
                                                 double corner_reach);
}  // namespace slalom::spline::detail
