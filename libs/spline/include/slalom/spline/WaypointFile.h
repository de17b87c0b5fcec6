// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <optional>

namespace slalom::spline
{
struct Waypoints
{
  Eigen::Matrix3Xd points_W;           ///< 3xM [m], M >= 1
  std::optional<Eigen::VectorXd> yaw;  ///< M [rad]
};

/** Reads a waypoint file: `x,y,z[,yaw_rad]` per line (all lines with a yaw or none), or one row of
 * the paper's dataset, `path_id, world, x1,y1,z1, x2,y2,z2, ...`. A header line, blank lines, lines
 * that begin with # and commas at the end of a line are skipped.
 *  @throws std::runtime_error naming file, line and value */
[[nodiscard]] Waypoints readWaypoints(const std::filesystem::path& file);

}  // namespace slalom::spline
