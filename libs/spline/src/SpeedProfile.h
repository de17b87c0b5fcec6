// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "WaypointPath.h"

namespace slalom::spline::detail
{
/** The fastest passage along a path, at rest at both ends, whose velocity and acceleration keep
 * per-axis limits.
 *
 *  With x = (dq/dt)^2 and w = d2q/dt2 every limit is linear: |p' w + p'' x| <= a, |p'|^2 x <= v^2;
 * see Reachability.h. w is constant between grid points. */
class SpeedProfile
{
 public:
  SpeedProfile(const std::vector<PathPiece>& pieces, double max_speed, double max_acceleration);

  [[nodiscard]] double duration() const { return nodes_.back().t; }
  /// Position at time t, which is clamped to [0, duration()].
  [[nodiscard]] Eigen::Vector3d position(double t) const;

 private:
  struct Node
  {
    std::size_t piece;  ///< piece of the interval that starts here
    double q;           ///< parameter in that piece
    double step;        ///< parameter length of that interval
    double x = 0.0;     ///< (dq/dt)^2
    double t = 0.0;
  };
  void makeGrid();

  const std::vector<PathPiece>& pieces_;
  std::vector<Node> nodes_;  ///< the last one only closes the last interval
};
}  // namespace slalom::spline::detail
