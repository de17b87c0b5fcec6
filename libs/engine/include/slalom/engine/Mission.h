// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <filesystem>

namespace slalom::engine
{
/// Where to fly: waypoints in the world frame, the last one is the goal.
struct Mission
{
  Eigen::Matrix3Xd waypoints_W;  ///< 3xM [m], M >= 1; the vehicle's position is put in front
};

/** Reads a waypoint file: `x,y,z[,yaw_rad]` per line, or the dataset rows `path_id, world,
 * x1,y1,z1, ...` (first row is taken). A header line, blank lines and lines that begin with # are
 * skipped.
 *  @throws std::runtime_error naming file, line and value */
[[nodiscard]] Mission readMission(const std::filesystem::path& file);

}  // namespace slalom::engine
