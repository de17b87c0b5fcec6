// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

namespace slalom::engine
{
/// Where to fly: waypoints in the world frame, the last one is the goal.
struct Mission
{
  Eigen::Matrix3Xd waypoints_W;  ///< 3xM [m], M >= 1; the vehicle's position is put in front
};

}  // namespace slalom::engine
