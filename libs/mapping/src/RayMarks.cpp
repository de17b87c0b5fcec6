// SPDX-License-Identifier: BSD-3-Clause
#include "RayMarks.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

namespace slalom::mapping::detail
{
namespace
{
constexpr std::size_t kBatch = 512;  // lines that are sorted and traversed together: fits L1/L2

// std::floor is a call without SSE 4.1.
int floorToInt(double value)
{
  const int whole = static_cast<int>(value);
  return whole - (value < whole);
}

// In single precision, as OctoMap measures.
double lengthOf(const Eigen::Vector3f& v)
{
  const float squared = v.x() * v.x() + v.y() * v.y() + v.z() * v.z();
  return std::sqrt(static_cast<double>(squared));
}

// The line from a point in `cell` to the centre of another cell. Borders are summed in double
// precision from single precision points: OctoMap's arithmetic, to the last bit.
GridLine lineBetween(const Eigen::Vector3f& origin, const Eigen::Vector3f& end,
                     const Eigen::Vector3i& cell, double resolution)
{
  constexpr double kNever = std::numeric_limits<double>::max();
  const Eigen::Vector3f offset = end - origin;
  const float length = static_cast<float>(lengthOf(offset));
  GridLine line;
  line.length = static_cast<double>(length);
  for (int axis = 0; axis < 3; ++axis)
  {
    const float along = offset[axis] / length;
    const int step = (along > 0.0f) - (along < 0.0f);
    line.stride[axis] = step;
    line.next[axis] = line.gap[axis] = kNever;
    if (step == 0) continue;
    const double border = (cell[axis] + 0.5) * resolution +
                          static_cast<double>(static_cast<float>(step * resolution * 0.5));
    line.next[axis] = (border - static_cast<double>(origin[axis])) / static_cast<double>(along);
    line.gap[axis] = resolution / std::fabs(static_cast<double>(along));
  }
  return line;
}

}  // namespace

RayMarks::RayMarks(const Eigen::Vector3i& window, double resolution, double min_range,
                   double max_range)
    : shape_{window + Eigen::Vector3i::Constant(2 * kMargin)},
      resolution_(resolution),
      cells_per_metre_(1.0 / resolution),
      min_range_(min_range),
      max_range_(max_range),
      marks_(shape_.cells() + 1, 0)
{
  lines_.reserve(kBatch);
}

inline Eigen::Vector3i RayMarks::cellOf(const Eigen::Vector3f& p_L) const
{
  return {floorToInt(cells_per_metre_ * static_cast<double>(p_L.x())) - first_cell_.x(),
          floorToInt(cells_per_metre_ * static_cast<double>(p_L.y())) - first_cell_.y(),
          floorToInt(cells_per_metre_ * static_cast<double>(p_L.z())) - first_cell_.z()};
}

inline Eigen::Vector3f RayMarks::centreOf(const Eigen::Vector3i& cell) const
{
  return (((cell + first_cell_).cast<double>().array() + 0.5) * resolution_).cast<float>();
}

RayMarks::Count RayMarks::cast(const Eigen::Vector3i& first_cell, std::span<const core::Ray> rays,
                               std::span<const std::uint8_t> free_only)
{
  first_cell_ = first_cell;
  const float reach = static_cast<float>(1e9 * resolution_);  // cells that fit an int
  const float min_squared = static_cast<float>(min_range_ * min_range_);
  Count count;
  for (std::size_t i = 0; i < rays.size(); ++i)
  {
    const core::Ray& ray = rays[i];
    const Eigen::Vector3f o = ray.origin_L, e = ray.end_L;
    // Written so that a comparison with NaN fails.
    const bool valid = (std::fabs(o.x()) < reach) & (std::fabs(o.y()) < reach) &
                       (std::fabs(o.z()) < reach) & (std::fabs(e.x()) < reach) &
                       (std::fabs(e.y()) < reach) & (std::fabs(e.z()) < reach);
    if (!valid) continue;
    const float squared = (e - o).squaredNorm();
    if ((squared < min_squared) | (squared == 0.0f)) continue;

    // Most returns share a voxel with an earlier one.
    Eigen::Vector3i end = cellOf(e);
    std::uint8_t* mark = inside(end, 0) ? marks_.data() + offset(end) : nullptr;
    const bool through = i < free_only.size() && free_only[i] != 0;
    if (mark != nullptr && (*mark & kHit) != 0)
    {
      ++(through ? count.free_only : count.fused);
      continue;
    }
    const bool in_range = lengthOf(centreOf(end) - o) <= max_range_;
    const bool hit = in_range && !through;
    ++(hit ? count.fused : (in_range ? count.free_only : count.beyond_range));
    if (!in_range)
    {
      const double range = std::sqrt(static_cast<double>(squared));
      end = cellOf(o + static_cast<float>(std::min(1.0, max_range_ / range)) * (e - o));
      mark = inside(end, 0) ? marks_.data() + offset(end) : nullptr;
    }
    if (mark != nullptr)
    {
      const bool cast_before = (*mark & kCast) != 0;
      *mark |= hit ? kCast | kHit : kCast;
      if (cast_before) continue;
    }
    castLine(o, end);
  }
  traverse(lines_, kPassed, marks_.data(), static_cast<std::int64_t>(shape_.cells()));
  lines_.clear();
  return count;
}

void RayMarks::castLine(const Eigen::Vector3f& origin_L, const Eigen::Vector3i& end)
{
  const Eigen::Vector3i from = cellOf(origin_L);
  if (from == end) return;
  GridLine line = lineBetween(origin_L, centreOf(end), from + first_cell_, resolution_);
  line.steps = (end - from).cwiseAbs().sum();
  // Rounding may carry a line one cell past its box before its length stops it.
  if (!inside(from, 1) || !inside(end, 1) || line.steps > kMaxSteps) return walk(line, from, end);
  ++line.steps;
  line.stride[1] *= shape_.pitch();
  line.stride[2] *= static_cast<std::int64_t>(shape_.row(0, 1));
  line.from = offset(from);
  line.to = offset(end);
  lines_.push_back(line);
  if (lines_.size() < kBatch) return;
  traverse(lines_, kPassed, marks_.data(), static_cast<std::int64_t>(shape_.cells()));
  lines_.clear();
}

// The same for lines that leave the grid.
void RayMarks::walk(GridLine& line, Eigen::Vector3i cell, const Eigen::Vector3i& end)
{
  for (;;)
  {
    if (inside(cell, 0)) marks_[offset(cell)] |= kPassed;
    const double* next = line.next;
    const int axis = next[0] < next[1] ? (next[0] < next[2] ? 0 : 2) : (next[1] < next[2] ? 1 : 2);
    cell[axis] += static_cast<int>(line.stride[axis]);
    line.next[axis] += line.gap[axis];
    if (cell == end || std::min({next[0], next[1], next[2]}) > line.length) return;
  }
}

void RayMarks::clearMargin()
{
  const int ny = shape_.size.y() - 2 * kMargin, nz = shape_.size.z() - 2 * kMargin;
  const std::size_t slab = shape_.row(0, 1), pitch = shape_.pitch();
  const std::size_t row_end = shape_.size.x() - kMargin;
  std::memset(marks_.data(), 0, kMargin * slab);
  std::memset(marks_.data() + (kMargin + nz) * slab, 0, kMargin * slab);
  for (int z = kMargin; z < kMargin + nz; ++z)
  {
    std::memset(marks_.data() + shape_.row(0, z), 0, kMargin * pitch);
    std::memset(marks_.data() + shape_.row(kMargin + ny, z), 0, kMargin * pitch);
    for (int y = kMargin; y < kMargin + ny; ++y)
    {
      std::uint8_t* row = marks_.data() + shape_.row(y, z);
      std::memset(row, 0, kMargin);
      std::memset(row + row_end, 0, kMargin);
    }
  }
}

}  // namespace slalom::mapping::detail
