// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <stdexcept>

#include "slalom/core/TextTable.h"
#include "slalom/simulation/ScriptedFlight.h"
#include "slalom/spline/WaypointFile.h"

namespace slalom::simulation
{
namespace
{
using core::failAt;
using core::TextRow;

std::vector<Waypoint> waypointsOf(const std::filesystem::path& file)
{
  const spline::Waypoints given = spline::readWaypoints(file);
  std::vector<Waypoint> waypoints(static_cast<std::size_t>(given.points_W.cols()));
  for (std::size_t i = 0; i < waypoints.size(); ++i)
  {
    waypoints[i].p_W = given.points_W.col(static_cast<Eigen::Index>(i));
    if (given.yaw) waypoints[i].yaw = (*given.yaw)[static_cast<Eigen::Index>(i)];
  }
  return waypoints;
}
}  // namespace

std::vector<core::TimedPose> readTum(const std::filesystem::path& file)
{
  std::vector<core::TimedPose> poses;
  for (const TextRow& row : core::readRows(file, 0))
  {
    if (row.fields.size() != 8)
      failAt(file, row.line,
             std::to_string(row.fields.size()) + " fields where t x y z qx qy qz qw are needed");
    const auto n = [&](std::size_t k) { return core::numberAt(file, row, k); };
    core::TimedPose pose;
    pose.t = n(0);
    pose.position = {n(1), n(2), n(3)};
    const Eigen::Quaterniond q(n(7), n(4), n(5), n(6));
    if (std::abs(q.norm() - 1.0) > 1e-2)
      failAt(file, row.line, "quaternion of norm " + std::to_string(q.norm()));
    pose.orientation = q.normalized();
    if (!poses.empty() && !(pose.t > poses.back().t))
      failAt(file, row.line, "time " + row.fields[0] + " is not after the one before");
    poses.push_back(pose);
  }
  if (poses.empty()) failAt(file, 1, "no poses");
  return poses;
}

ScriptedFlight ScriptedFlight::load(const std::filesystem::path& file, const FlightConfig& config)
{
  const std::vector<TextRow> rows = core::readRows(file, ',');
  if (rows.empty()) failAt(file, 1, "no waypoints and no poses");
  const bool csv = rows.front().fields.size() > 1;
  try
  {
    return csv ? through(waypointsOf(file), config) : along(readTum(file), config);
  }
  catch (const std::invalid_argument& error)
  {
    throw std::runtime_error(file.string() + ": " + error.what());
  }
}

}  // namespace slalom::simulation
