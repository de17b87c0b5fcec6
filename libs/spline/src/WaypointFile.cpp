// SPDX-License-Identifier: BSD-3-Clause
#include "slalom/spline/WaypointFile.h"

#include <algorithm>
#include <string>
#include <vector>

#include "slalom/core/TextTable.h"

namespace slalom::spline
{
namespace
{
using core::failAt;
using core::TextRow;

constexpr std::size_t kPathHead = 2;  // path_id, world

bool isHeader(const TextRow& row)
{
  return std::none_of(row.fields.begin(), row.fields.end(),
                      [](const std::string& field) { return core::parseNumber(field); });
}

/// Spreadsheets fill short rows up with commas.
void dropEmptyEnd(TextRow& row)
{
  while (!row.fields.empty() && row.fields.back().empty()) row.fields.pop_back();
}

Eigen::Vector3d pointAt(const std::filesystem::path& file, const TextRow& row, std::size_t k)
{
  return {core::numberAt(file, row, k), core::numberAt(file, row, k + 1),
          core::numberAt(file, row, k + 2)};
}

Waypoints readPath(const std::filesystem::path& file, const TextRow& row)
{
  Waypoints path;
  path.points_W.resize(3, static_cast<Eigen::Index>((row.fields.size() - kPathHead) / 3));
  for (Eigen::Index i = 0; i < path.points_W.cols(); ++i)
    path.points_W.col(i) = pointAt(file, row, kPathHead + 3 * static_cast<std::size_t>(i));
  return path;
}

Waypoints readLines(const std::filesystem::path& file, const std::vector<TextRow>& rows)
{
  const auto count = static_cast<Eigen::Index>(rows.size());
  const std::size_t width = rows.front().fields.size();
  Waypoints waypoints;
  waypoints.points_W.resize(3, count);
  if (width == 4) waypoints.yaw = Eigen::VectorXd(count);
  for (Eigen::Index i = 0; i < count; ++i)
  {
    const TextRow& row = rows[static_cast<std::size_t>(i)];
    const std::size_t fields = row.fields.size();
    if (fields != 3 && fields != 4)
      failAt(file, row.line, std::to_string(fields) + " fields where x,y,z[,yaw_rad] are needed");
    if (fields != width) failAt(file, row.line, "either all waypoints have a yaw or none has");
    waypoints.points_W.col(i) = pointAt(file, row, 0);
    if (waypoints.yaw) (*waypoints.yaw)[i] = core::numberAt(file, row, 3);
  }
  return waypoints;
}
}  // namespace

Waypoints readWaypoints(const std::filesystem::path& file)
{
  std::vector<TextRow> rows = core::readRows(file, ',');
  for (TextRow& row : rows) dropEmptyEnd(row);
  if (!rows.empty() && !rows.front().fields.empty() && isHeader(rows.front()))
    rows.erase(rows.begin());
  if (rows.empty()) failAt(file, 1, "no waypoint in it");
  const std::size_t fields = rows.front().fields.size();
  if (fields < kPathHead + 3) return readLines(file, rows);
  if ((fields - kPathHead) % 3 != 0)
    failAt(file, rows.front().line,
           std::to_string(fields) +
               " fields are neither x,y,z[,yaw_rad] nor a row of path_id, world, x1,y1,z1, ...");
  if (rows.size() > 1) failAt(file, rows[1].line, "a second path: give a file with the one to fly");
  return readPath(file, rows.front());
}

}  // namespace slalom::spline
