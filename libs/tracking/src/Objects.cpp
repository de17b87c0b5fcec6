// SPDX-License-Identifier: BSD-3-Clause
#include "Objects.h"

#include <algorithm>
#include <cmath>

namespace slalom::tracking::detail
{
namespace
{
constexpr float kHalfHeight = 4.0f;   // [m] of the grid above and below the sensor
constexpr float kGroundStep = 0.25f;  // [m] height that flat ground may gain from cell to cell

}  // namespace

Object fitObject(const Eigen::Vector3f& origin_L, std::span<const core::Ray> rays,
                 std::span<const std::uint32_t> chosen)
{
  Object object;
  object.rays = chosen;
  Eigen::Vector3f sum = Eigen::Vector3f::Zero();
  for (const std::uint32_t i : chosen) sum += rays[i].end_L - origin_L;
  const Eigen::Vector3f mean = sum / static_cast<float>(chosen.size());
  const float planar = mean.head<2>().norm();
  const Eigen::Vector2f sight = mean.head<2>() / std::max(planar, 1e-3f);

  float left = 1e9f, right = -1e9f, low = 1e9f, high = -1e9f;
  for (const std::uint32_t i : chosen)
  {
    const Eigen::Vector3f d = rays[i].end_L - origin_L;
    const float across = sight.x() * d.y() - sight.y() * d.x();
    left = std::min(left, across), right = std::max(right, across);
    low = std::min(low, d.z()), high = std::max(high, d.z());
  }
  const double half_width = 0.5 * static_cast<double>(right - left);
  // From nearby one sees less than half of a round thing.
  const double seen = half_width / std::max(static_cast<double>(planar) + half_width, 0.5);
  object.half_width_m = half_width * (1.0 + 0.5 * seen * seen);
  object.half_height_m = 0.5 * static_cast<double>(high - low);
  // The visible half of a sphere or an upright cylinder lies 2/3 to pi/4 of its radius in front of
  // the axis, on average over its width.
  constexpr double kDepth = 0.72;
  const Eigen::Vector2d axis = (mean.head<2>() + origin_L.head<2>()).cast<double>() +
                               kDepth * std::min(object.half_width_m, 0.8) * sight.cast<double>();
  object.centre_L << axis, static_cast<double>(origin_L.z() + 0.5f * (low + high));
  return object;
}

double transparency(const Eigen::Vector3f& origin_L, std::span<const core::Ray> rays,
                    const Object& object)
{
  constexpr double kCore = 0.6;    // of the half extents
  constexpr float kBeyond = 0.3f;  // [m]
  const Eigen::Vector3f to = object.centre_L.cast<float>() - origin_L;
  const float width = static_cast<float>(kCore * object.half_width_m);
  const float height = static_cast<float>(kCore * object.half_height_m);
  const float depth = static_cast<float>(object.half_width_m) + kBeyond;
  const float planar = to.head<2>().norm();
  int stopped = 0, through = 0;
  for (const core::Ray& ray : rays)
  {
    const Eigen::Vector3f d = ray.end_L - origin_L;
    const float length = d.head<2>().norm();
    const float across = to.x() * d.y() - to.y() * d.x();
    const float along = to.head<2>().dot(d.head<2>());
    if (!(std::fabs(across) <= width * length && along > 0.0f)) continue;
    const float rise = d.z() * planar - to.z() * length;
    if (!(std::fabs(rise) <= height * length)) continue;
    if (length > planar + depth)
      ++through;
    else if (length > planar - depth)
      ++stopped;
  }
  return through > 0 ? static_cast<double>(through) / (through + stopped) : 0.0;
}

ObjectFinder::ObjectFinder(const TrackingConfig& config)
    : config_(config),
      size_xy_(2 * static_cast<int>(std::ceil(config.range_m / config.cell_m)) + 4),
      size_z_(2 * static_cast<int>(std::ceil(kHalfHeight / config.cell_m)) + 4),
      cell_grid_(static_cast<std::size_t>(size_xy_) * size_xy_ * size_z_, -1),
      column_grid_(static_cast<std::size_t>(size_xy_) * size_xy_, -1)
{
}

const std::vector<Object>& ObjectFinder::find(const Eigen::Vector3f& origin_L,
                                              std::span<const core::Ray> rays)
{
  clear();
  fill(origin_L, rays);
  findGround();
  joinCells();
  sortReturns();
  for (std::size_t i = 0; i < cells_.size(); ++i)
  {
    const Node& node = cells_[i];
    if (node.parent != static_cast<int>(i) || !compact(node)) continue;
    const std::span<const std::uint32_t> chosen(sorted_.data() + node.first,
                                                static_cast<std::size_t>(node.count));
    objects_.push_back(fitObject(origin_L, rays, chosen));
  }
  return objects_;
}

void ObjectFinder::clear()
{
  for (const Node& cell : cells_) cell_grid_[static_cast<std::size_t>(cell.at)] = -1;
  for (const Node& column : columns_) column_grid_[static_cast<std::size_t>(column.at)] = -1;
  cells_.clear();
  columns_.clear();
  near_.clear();
  cell_of_.clear();
  objects_.clear();
}

int ObjectFinder::add(std::vector<Node>& nodes, std::vector<int>& grid, int at,
                      const Eigen::Vector3f& p)
{
  int& number = grid[static_cast<std::size_t>(at)];
  if (number < 0)
  {
    number = static_cast<int>(nodes.size());
    nodes.push_back(Node{at, number, 0, 0, 0, p, p, 0.0f});
  }
  Node& node = nodes[static_cast<std::size_t>(number)];
  ++node.count;
  node.low = node.low.cwiseMin(p);
  node.high = node.high.cwiseMax(p);
  return number;
}

void ObjectFinder::fill(const Eigen::Vector3f& origin_L, std::span<const core::Ray> rays)
{
  // Cells are those of one lattice in L, so that what is at rest is cut the same way in all scans.
  const float edge = static_cast<float>(config_.cell_m), per_metre = 1.0f / edge;
  const Eigen::Vector3f half =
      edge * 0.5f *
      Eigen::Vector3f(static_cast<float>(size_xy_), static_cast<float>(size_xy_),
                      static_cast<float>(size_z_));
  const Eigen::Vector3f corner = edge * ((origin_L - half) * per_metre).array().round().matrix();
  const float far = static_cast<float>(config_.range_m * config_.range_m);
  const float close = static_cast<float>(config_.min_range_m * config_.min_range_m);
  for (std::size_t i = 0; i < rays.size(); ++i)
  {
    const Eigen::Vector3f p = rays[i].end_L;
    const Eigen::Vector3f d = p - origin_L;
    const float squared = d.squaredNorm();
    if (!(squared <= far && squared >= close && std::fabs(d.z()) <= kHalfHeight)) continue;
    const Eigen::Vector3f q = (p - corner) * per_metre;
    const int x = static_cast<int>(q.x()), y = static_cast<int>(q.y()), z = static_cast<int>(q.z());
    const int at_column = y * size_xy_ + x;
    const int number = add(cells_, cell_grid_, z * size_xy_ * size_xy_ + at_column, p);
    Node& cell = cells_[static_cast<std::size_t>(number)];
    if (cell.count == 1) cell.column = add(columns_, column_grid_, at_column, p);
    near_.push_back(static_cast<std::uint32_t>(i));
    cell_of_.push_back(number);
  }
  for (const Node& cell : cells_)
  {
    Node& column = columns_[static_cast<std::size_t>(cell.column)];
    column.low = column.low.cwiseMin(cell.low);
    column.high = column.high.cwiseMax(cell.high);
  }
}

int ObjectFinder::rootOf(std::vector<Node>& nodes, int i)
{
  for (;;)
  {
    Node& node = nodes[static_cast<std::size_t>(i)];
    if (node.parent == i) return i;
    node.parent = nodes[static_cast<std::size_t>(node.parent)].parent;
    i = node.parent;
  }
}

void ObjectFinder::join(std::vector<Node>& nodes, int a, int b)
{
  a = rootOf(nodes, a), b = rootOf(nodes, b);
  if (a == b) return;
  Node& root = nodes[static_cast<std::size_t>(std::min(a, b))];
  Node& other = nodes[static_cast<std::size_t>(std::max(a, b))];
  other.parent = std::min(a, b);
  root.count += other.count;
  root.low = root.low.cwiseMin(other.low);
  root.high = root.high.cwiseMax(other.high);
}

void ObjectFinder::findGround()
{
  is_ground_.assign(columns_.size(), 0);
  for (std::size_t i = 0; i < columns_.size(); ++i)
  {
    columns_[i].base = columns_[i].low.z();
    is_ground_[i] = columns_[i].high.z() - columns_[i].low.z() < kGroundStep;
  }
  const int forward[4] = {1, size_xy_ - 1, size_xy_, size_xy_ + 1};
  for (std::size_t i = 0; i < columns_.size(); ++i)
  {
    if (!is_ground_[i]) continue;
    for (const int step : forward)
    {
      const int other = column_grid_[static_cast<std::size_t>(columns_[i].at + step)];
      if (other < 0 || !is_ground_[static_cast<std::size_t>(other)]) continue;
      const float rise = columns_[static_cast<std::size_t>(other)].base - columns_[i].base;
      if (std::fabs(rise) < kGroundStep) join(columns_, static_cast<int>(i), other);
    }
  }
  for (std::size_t i = 0; i < columns_.size(); ++i)
  {
    const Node& root = columns_[static_cast<std::size_t>(rootOf(columns_, static_cast<int>(i)))];
    const Eigen::Vector3f extent = root.high - root.low;
    is_ground_[i] =
        is_ground_[i] && extent.head<2>().maxCoeff() > static_cast<float>(config_.max_extent_m);
  }
}

void ObjectFinder::joinCells()
{
  const int slab = size_xy_ * size_xy_;
  int forward[13], n = 0;
  for (int z = 0; z <= 1; ++z)
    for (int y = -1; y <= 1; ++y)
      for (int x = -1; x <= 1; ++x)
        if (const int step = z * slab + y * size_xy_ + x; step > 0) forward[n++] = step;
  const auto ground = [this](int cell)
  {
    return is_ground_[static_cast<std::size_t>(cells_[static_cast<std::size_t>(cell)].column)] != 0;
  };
  for (int i = 0; i < static_cast<int>(cells_.size()); ++i)
  {
    if (ground(i)) continue;
    for (int k = 0; k < n; ++k)
    {
      const int other =
          cell_grid_[static_cast<std::size_t>(cells_[static_cast<std::size_t>(i)].at + forward[k])];
      if (other >= 0 && !ground(other)) join(cells_, i, other);
    }
  }
}

void ObjectFinder::sortReturns()
{
  int first = 0;
  for (std::size_t i = 0; i < cells_.size(); ++i)
    if (cells_[i].parent == static_cast<int>(i)) cells_[i].first = first, first += cells_[i].count;
  sorted_.resize(near_.size());
  for (std::size_t k = 0; k < near_.size(); ++k)
  {
    Node& root = cells_[static_cast<std::size_t>(rootOf(cells_, cell_of_[k]))];
    sorted_[static_cast<std::size_t>(root.first++)] = near_[k];
  }
  for (std::size_t i = 0; i < cells_.size(); ++i)
    if (cells_[i].parent == static_cast<int>(i)) cells_[i].first -= cells_[i].count;
}

bool ObjectFinder::compact(const Node& root) const
{
  const Eigen::Vector3f extent = root.high - root.low;
  return root.count >= config_.min_points &&
         extent.maxCoeff() <= static_cast<float>(config_.max_extent_m) &&
         extent.z() >= static_cast<float>(config_.min_height_m) &&
         !is_ground_[static_cast<std::size_t>(root.column)];
}

}  // namespace slalom::tracking::detail
