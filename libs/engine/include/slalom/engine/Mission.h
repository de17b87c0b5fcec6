// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

namespace slalom::engine
{
struct EngineConfig;

/// Where to fly: waypoints in the world frame, the last one is the goal.
struct Mission
{
  Eigen::Matrix3Xd waypoints_W;  ///< 3xM [m], M >= 1; the vehicle's position is put in front
};

/** A reference takes memory in proportion to its length, and a mistyped coordinate must not take
 * the machine. Bounds: 10 000 waypoints, coordinates of +-1e6 m, mission.max_length_m, and a
 * million knot spans at the speed that is planned with.
 *  @throws std::invalid_argument naming key, value and bound */
void check(const Mission& mission, const EngineConfig& config);

}  // namespace slalom::engine
