// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <optional>

namespace slalom::global_planner
{
/** Where the plane through c_j normal to c_{j+1} - c_{j-1} crosses the polyline S_* [Paper
 * Algorithm 2, Eq. (3)].
 *
 *  All edges are tested and the crossing nearest to c_j is taken (deviation D-05: the printed walk
 * steps the wrong way, keeps a stale v2 and reads past the end).
 *  @param before, at, after c_{j-1}, c_j, c_{j+1} [m]
 *  @param path S_*, one point per column
 *  @return c_j^* [m], or nullopt if the plane is undefined or does not meet S_* */
[[nodiscard]] std::optional<Eigen::Vector3d> crossing(const Eigen::Vector3d& before,
                                                      const Eigen::Vector3d& at,
                                                      const Eigen::Vector3d& after,
                                                      const Eigen::Matrix3Xd& path);

}  // namespace slalom::global_planner
