// SPDX-License-Identifier: BSD-3-Clause
/** What moves in a world: balls and upright cylinders (persons) on paths that are known functions
 * of time. */
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

namespace slalom::simulation
{
/// What a mover does at its last waypoint.
enum class AtEnd
{
  Stop,
  Return,  ///< the same way back, and again
  Loop     ///< straight to the first waypoint, and on
};

/** Where the point that carries a mover is at a time: begins at `start`, and
 *
 *    waypoints given:   walks through them at `speed`
 *    otherwise:         start + velocity t + amplitude sin(2 pi t / period + phase)
 *
 *  with t counted from `delay` on (it waits until then: t = 0). Pure. */
struct MoverPath
{
  Eigen::Vector3d start_W = Eigen::Vector3d::Zero();      ///< [m]
  Eigen::Vector3d velocity_W = Eigen::Vector3d::Zero();   ///< [m/s]
  Eigen::Vector3d amplitude_W = Eigen::Vector3d::Zero();  ///< [m]
  double period_s = 1.0;                                  ///< [s] > 0
  double phase = 0.0;                                     ///< [rad]
  std::vector<Eigen::Vector3d> waypoints_W;               ///< [m]; none, or two or more
  double speed = 1.0;                                     ///< [m/s] > 0 through the waypoints
  AtEnd at_end = AtEnd::Return;
  double delay_s = 0.0;  ///< [s] may be negative: it has moved for so long at time 0

  [[nodiscard]] Eigen::Vector3d at(double t) const;  ///< [m]
};

/// A ball around the path (height 0), or an upright cylinder whose foot is on the path.
struct Mover
{
  std::string name;
  double radius = 0.3;  ///< [m] > 0
  double height = 0.0;  ///< [m] of the cylinder; 0 = a ball
  MoverPath path;
};

/// The movers of a world at one instant.
class MoversAt
{
 public:
  MoversAt(const std::vector<Mover>& movers, double t);

  /// First mover along a ray, as World::castRay. @param direction unit vector
  [[nodiscard]] std::optional<double> castRay(const Eigen::Vector3d& origin_W,
                                              const Eigen::Vector3d& direction,
                                              double max_range) const;
  /// To the nearest surface [m], negative inside; infinite without movers.
  [[nodiscard]] double distance(const Eigen::Vector3d& p_W) const;
  [[nodiscard]] bool empty() const { return bodies_.empty(); }

 private:
  struct Body
  {
    Eigen::Vector3d p_W;
    double radius, height;
  };
  std::vector<Body> bodies_;
};

}  // namespace slalom::simulation
