// SPDX-License-Identifier: BSD-3-Clause
#include "slalom/engine/Mission.h"

#include <charconv>
#include <cmath>
#include <fstream>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace slalom::engine
{
namespace
{
std::string_view trim(std::string_view text)
{
  const auto from = text.find_first_not_of(" \t\r");
  if (from == std::string_view::npos) return {};
  return text.substr(from, text.find_last_not_of(" \t\r") - from + 1);
}

std::vector<std::string_view> split(std::string_view line)
{
  std::vector<std::string_view> cells;
  for (std::size_t from = 0; from <= line.size();)
  {
    const std::size_t comma = std::min(line.find(',', from), line.size());
    cells.push_back(trim(line.substr(from, comma - from)));
    from = comma + 1;
  }
  while (!cells.empty() && cells.back().empty()) cells.pop_back();
  return cells;
}

std::optional<double> number(std::string_view cell)
{
  double value = 0.0;
  const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
  if (error != std::errc{} || end != cell.data() + cell.size() || !std::isfinite(value))
    return std::nullopt;
  return value;
}

Eigen::Matrix3Xd toMatrix(const std::vector<Eigen::Vector3d>& points)
{
  Eigen::Matrix3Xd matrix(3, static_cast<Eigen::Index>(points.size()));
  for (std::size_t i = 0; i < points.size(); ++i) matrix.col(Eigen::Index(i)) = points[i];
  return matrix;
}

}  // namespace

Mission readMission(const std::filesystem::path& file)
{
  std::ifstream in(file);
  if (!in) throw std::runtime_error(file.string() + ": cannot be read");
  std::vector<Eigen::Vector3d> points;
  std::string line;
  for (int line_number = 1; std::getline(in, line); ++line_number)
  {
    const std::string_view text = trim(line);
    if (text.empty() || text.front() == '#') continue;
    const std::vector<std::string_view> cells = split(text);
    const auto complain = [&](const std::string& what)
    { throw std::runtime_error(file.string() + ":" + std::to_string(line_number) + ": " + what); };
    const bool first_is_number = number(cells[0]).has_value();
    if (!first_is_number && points.empty() && cells.size() >= 2 && !number(cells[1]))
      continue;  // header
    // A dataset row has a world's name in its second cell and all its points on one line.
    const bool dataset_row = cells.size() >= 5 && !number(cells[1]);
    const std::size_t begin = dataset_row ? 2 : 0;
    if (dataset_row ? (cells.size() - begin) % 3 != 0 : cells.size() != 3 && cells.size() != 4)
      complain("expected x,y,z[,yaw_rad] or path_id,world,x1,y1,z1,..., found " +
               std::to_string(cells.size()) + " values");
    for (std::size_t i = begin; i + 2 < cells.size(); i += 3)
    {
      Eigen::Vector3d p;
      for (std::size_t k = 0; k < 3; ++k)
      {
        const std::optional<double> value = number(cells[i + k]);
        if (!value) complain("'" + std::string(cells[i + k]) + "' is not a finite number");
        p[Eigen::Index(k)] = *value;
      }
      points.push_back(p);
    }
    if (dataset_row) break;
  }
  if (points.empty()) throw std::runtime_error(file.string() + ": no waypoint in it");
  return {toMatrix(points)};
}

}  // namespace slalom::engine
