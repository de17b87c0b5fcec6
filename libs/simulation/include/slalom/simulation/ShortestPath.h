// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <optional>

#include "slalom/simulation/World.h"

namespace slalom::simulation
{
/** The shortest way of a ball through what stands in a world, as if all of it were known, in the
 * plane that holds start and goal and is level across: at one height between ends of one height. A
 * way over or under an obstacle is not looked for. Any-angle search (lazy Theta*) on a grid of
 * 0.05 m, pulled tight against the true geometry; within the world's bounds, movers and the ground
 * apart. The way is free (to 0.1 mm), so its length is an upper bound of the shortest; gaps less
 * than a grid cell wider than the ball may be overlooked.
 *  @param radius [m] >= 0
 *  @return 3xN, one corner per column from start to goal [m]; nullopt if there is none or start or
 * goal are not free, or where the grid would be larger than about 100 x 100 m
 *  @see K. Daniel, A. Nash, S. Koenig, A. Felner: Theta*, JAIR 2010; Nash, Koenig, Tovey: Lazy
 * Theta*, AAAI 2010 */
[[nodiscard]] std::optional<Eigen::Matrix3Xd> shortestRoute(const World& world,
                                                            const Eigen::Vector3d& start_W,
                                                            const Eigen::Vector3d& goal_W,
                                                            double radius);

/// Length of shortestRoute() [m].
[[nodiscard]] std::optional<double> shortestPath(const World& world, const Eigen::Vector3d& start_W,
                                                 const Eigen::Vector3d& goal_W, double radius);

/** Where a vehicle should wait that cannot come to its goal: of the points that the ball can reach
 * and that are `clearance` from everything that stands, those least far from the goal; of them, as
 * they may be a whole circle, the one nearest to `from_W`. In the plane of shortestRoute(), within
 * the world's bounds, on a grid of 0.05 m: true to about one of its cells.
 *  @param radius [m] of the ball, >= 0
 *  @param clearance [m] of its centre, >= radius
 *  @return [m]; nullopt if there is none or the start is not free */
[[nodiscard]] std::optional<Eigen::Vector3d> nearestReachable(const World& world,
                                                              const Eigen::Vector3d& start_W,
                                                              const Eigen::Vector3d& goal_W,
                                                              const Eigen::Vector3d& from_W,
                                                              double radius, double clearance);

}  // namespace slalom::simulation
