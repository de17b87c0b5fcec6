// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <fstream>
#include <stdexcept>

#include "TextFile.h"
#include "slalom/simulation/ScriptedFlight.h"

namespace slalom::simulation
{
namespace
{
using detail::failAt;
using detail::numberAt;
using detail::Row;

/// `path_id, world, x1,y1,z1, ...`
std::vector<Waypoint> readPaperRow(const std::filesystem::path& file, const Row& row)
{
  if ((row.fields.size() - 2) % 3 != 0)
    failAt(file, row.line,
           std::to_string(row.fields.size()) +
               " fields are neither x,y,z[,yaw] nor a row of "
               "path_id, world, x1,y1,z1, ...");
  std::vector<Waypoint> waypoints;
  for (std::size_t k = 2; k < row.fields.size(); k += 3)
    waypoints.push_back(
        {{numberAt(file, row, k), numberAt(file, row, k + 1), numberAt(file, row, k + 2)}});
  return waypoints;
}

bool isHeader(const Row& row)
{
  return !row.fields.front().empty() && !detail::parseNumber(row.fields.front()) &&
         row.fields.size() <= 4;
}
}  // namespace

std::vector<Waypoint> readWaypoints(const std::filesystem::path& file)
{
  std::vector<Row> rows = detail::readRows(file, ',');
  if (!rows.empty() && isHeader(rows.front())) rows.erase(rows.begin());
  if (rows.empty()) failAt(file, 1, "no waypoints");
  if (rows.front().fields.size() >= 8)
  {
    if (rows.size() > 1)
      failAt(file, rows[1].line, "a second path: give a file with the one to fly");
    return readPaperRow(file, rows.front());
  }
  std::vector<Waypoint> waypoints;
  for (const Row& row : rows)
  {
    if (row.fields.size() != 3 && row.fields.size() != 4)
      failAt(file, row.line,
             std::to_string(row.fields.size()) + " fields where x,y,z[,yaw_rad] are needed");
    Waypoint waypoint;
    waypoint.p_W = {numberAt(file, row, 0), numberAt(file, row, 1), numberAt(file, row, 2)};
    if (row.fields.size() == 4) waypoint.yaw = numberAt(file, row, 3);
    waypoints.push_back(waypoint);
  }
  return waypoints;
}

std::vector<core::TimedPose> readTum(const std::filesystem::path& file)
{
  std::vector<core::TimedPose> poses;
  for (const Row& row : detail::readRows(file, 0))
  {
    if (row.fields.size() != 8)
      failAt(file, row.line,
             std::to_string(row.fields.size()) + " fields where t x y z qx qy qz qw are needed");
    const auto n = [&](std::size_t k) { return numberAt(file, row, k); };
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
  const std::vector<Row> rows = detail::readRows(file, ',');
  if (rows.empty()) failAt(file, 1, "no waypoints and no poses");
  const bool csv = rows.front().fields.size() > 1;
  try
  {
    return csv ? through(readWaypoints(file), config) : along(readTum(file), config);
  }
  catch (const std::invalid_argument& error)
  {
    throw std::runtime_error(file.string() + ": " + error.what());
  }
}

}  // namespace slalom::simulation
