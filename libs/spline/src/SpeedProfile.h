// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "WaypointPath.h"

namespace slalom::spline::detail
{
/** The fastest passage along a path, at rest at both ends, whose velocity and acceleration keep
 * per-axis limits.
 *
 *  With x = (dq/dt)^2 and w = d2q/dt2 every limit is linear: |p' w + p'' x| <= a, |p'|^2 x <= v^2.
 * A backward pass finds the largest x from which the end can be reached, a forward pass then takes
 * the largest w (reachability analysis; Pham and Pham 2018). w is constant between grid points. */
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
  void passBackward(double max_speed, double max_acceleration);
  void passForward(double max_acceleration);
  void makeTimes();

  const std::vector<PathPiece>& pieces_;
  std::vector<Node> nodes_;        ///< the last one only closes the last interval
  std::vector<double> reachable_;  ///< largest x per node from which the end can be reached
};
}  // namespace slalom::spline::detail
