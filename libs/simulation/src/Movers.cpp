// SPDX-License-Identifier: BSD-3-Clause
#include "slalom/simulation/Movers.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "Solids.h"

namespace slalom::simulation
{
namespace
{
/// The point so far along the waypoints, in order; the last one beyond their end.
Eigen::Vector3d along(const std::vector<Eigen::Vector3d>& waypoints, double way)
{
  for (std::size_t k = 1; k < waypoints.size(); ++k)
  {
    const Eigen::Vector3d leg = waypoints[k] - waypoints[k - 1];
    const double length = leg.norm();
    if (way <= length && length > 0.0) return waypoints[k - 1] + leg * (way / length);
    way -= length;
  }
  return waypoints.back();
}

double lengthOf(const std::vector<Eigen::Vector3d>& waypoints)
{
  double length = 0.0;
  for (std::size_t k = 1; k < waypoints.size(); ++k)
    length += (waypoints[k] - waypoints[k - 1]).norm();
  return length;
}

Eigen::Vector3d walked(const MoverPath& path, double t)
{
  const double whole = lengthOf(path.waypoints_W);
  double way = path.speed * t;
  if (!(whole > 0.0)) return path.waypoints_W.front();
  if (path.at_end == AtEnd::Stop) return along(path.waypoints_W, std::min(way, whole));
  if (path.at_end == AtEnd::Return)
  {
    way = std::fmod(way, 2.0 * whole);
    return along(path.waypoints_W, std::min(way, 2.0 * whole - way));
  }
  const Eigen::Vector3d &first = path.waypoints_W.front(), &last = path.waypoints_W.back();
  const double back = (last - first).norm();
  way = std::fmod(way, whole + back);
  return way <= whole ? along(path.waypoints_W, way)
                      : Eigen::Vector3d(last + (first - last) * ((way - whole) / back));
}
}  // namespace

Eigen::Vector3d MoverPath::at(double t) const
{
  const double moved = std::max(0.0, t - delay_s);
  if (!waypoints_W.empty()) return walked(*this, moved);
  return start_W + velocity_W * moved +
         amplitude_W * std::sin(2.0 * std::numbers::pi * moved / period_s + phase);
}

MoversAt::MoversAt(const std::vector<Mover>& movers, double t)
{
  bodies_.reserve(movers.size());
  for (const Mover& mover : movers)
    bodies_.push_back({mover.path.at(t), mover.radius, mover.height});
}

std::optional<double> MoversAt::castRay(const Eigen::Vector3d& origin_W,
                                        const Eigen::Vector3d& direction, double max_range) const
{
  double best = std::numeric_limits<double>::infinity();
  for (const Body& body : bodies_)
  {
    const Eigen::Vector3d from = origin_W - body.p_W;
    best = std::min(best, body.height > 0.0
                              ? detail::hitCylinder(from, direction, body.radius, body.height)
                              : detail::hitSphere(from, direction, body.radius));
  }
  if (best > max_range) return std::nullopt;
  return best;
}

double MoversAt::distance(const Eigen::Vector3d& p_W) const
{
  double best = std::numeric_limits<double>::infinity();
  for (const Body& body : bodies_)
    best = std::min(best, body.height > 0.0
                              ? detail::cylinderDistance(p_W - body.p_W, body.radius, body.height)
                              : (p_W - body.p_W).norm() - body.radius);
  return best;
}

}  // namespace slalom::simulation
