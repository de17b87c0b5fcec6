// SPDX-License-Identifier: BSD-3-Clause
#include "RayMarks.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace slalom::mapping::detail
{
namespace
{
// One line through the lattice. The distances at which it enters the next cell of each axis are
// advanced by addition in double precision, from single precision points: OctoMap's arithmetic.
class Line
{
 public:
  Line(const Eigen::Vector3f& origin, const Eigen::Vector3f& end, const Eigen::Vector3i& cell,
       double resolution)
  {
    Eigen::Vector3f direction = end - origin;
    const double squared = direction.x() * direction.x() + direction.y() * direction.y() +
                           direction.z() * direction.z();
    const float length_f = static_cast<float>(std::sqrt(squared));
    length = length_f;
    for (int axis = 0; axis < 3; ++axis)
    {
      const float along = direction[axis] / length_f;
      step[axis] = (along > 0.0f) - (along < 0.0f);
      if (step[axis] == 0) continue;
      const double border = (cell[axis] + 0.5) * resolution +
                            static_cast<double>(static_cast<float>(step[axis] * resolution * 0.5));
      next[axis] = (border - static_cast<double>(origin[axis])) / static_cast<double>(along);
      gap[axis] = resolution / std::fabs(static_cast<double>(along));
    }
  }

  [[nodiscard]] int nearestAxis() const
  {
    return next[0] < next[1] ? (next[0] < next[2] ? 0 : 2) : (next[1] < next[2] ? 1 : 2);
  }

  static constexpr double kNever = std::numeric_limits<double>::max();
  int step[3] = {0, 0, 0};
  double next[3] = {kNever, kNever, kNever};  // [m] along the line
  double gap[3] = {kNever, kNever, kNever};
  double length = 0.0;
};

}  // namespace

RayMarks::RayMarks(const GridShape& shape, double resolution, double min_range, double max_range)
    : shape_(shape),
      resolution_(resolution),
      cells_per_metre_(1.0 / resolution),
      min_range_(min_range),
      max_range_(max_range),
      marks_(shape.cells(), 0)
{
}

RayMarks::Count RayMarks::cast(const Eigen::Vector3i& first_cell, std::span<const core::Ray> rays)
{
  first_cell_ = first_cell;
  const float reach = static_cast<float>(1e9 * resolution_);  // cells that fit an int
  Count count;
  for (const core::Ray& ray : rays)
  {
    const float largest = std::max(ray.origin_L.cwiseAbs().maxCoeff<Eigen::PropagateNaN>(),
                                   ray.end_L.cwiseAbs().maxCoeff<Eigen::PropagateNaN>());
    const double range = (ray.end_L - ray.origin_L).cast<double>().norm();
    if (!(largest < reach && range >= min_range_ && range > 0.0)) continue;

    const auto centre = [this](const Eigen::Vector3i& cell) -> Eigen::Vector3f
    { return ((cell.cast<double>().array() + 0.5) * resolution_).cast<float>(); };
    Eigen::Vector3i end = cellOf(ray.end_L);
    Eigen::Vector3f target = centre(end);
    const Eigen::Vector3f offset = target - ray.origin_L;
    const double to_centre = std::sqrt(static_cast<double>(
        offset.x() * offset.x() + offset.y() * offset.y() + offset.z() * offset.z()));
    const bool hit = to_centre <= max_range_;
    if (!hit)
    {
      const float scale = static_cast<float>(std::min(1.0, max_range_ / range));
      end = cellOf(ray.origin_L + scale * (ray.end_L - ray.origin_L));
      target = centre(end);
    }
    ++(hit ? count.fused : count.beyond_range);

    end -= first_cell_;
    if (inside(end))
    {
      std::uint8_t& mark = row(end.y(), end.z())[end.x()];
      const bool known = (mark & kCast) != 0;
      mark |= hit ? kCast | kHit : kCast;
      if (known) continue;
    }
    traverse(ray.origin_L, target, cellOf(ray.origin_L) - first_cell_, end);
  }
  return count;
}

void RayMarks::traverse(const Eigen::Vector3f& origin_L, const Eigen::Vector3f& end_L,
                        const Eigen::Vector3i& from, const Eigen::Vector3i& to)
{
  if (from == to) return;
  Line line(origin_L, end_L, from + first_cell_, resolution_);
  const Eigen::Array3i low = from.array().min(to.array()), high = from.array().max(to.array());
  // Rounding may carry a line one cell past its box before its length stops it.
  const bool safe = (low >= 1).all() && (high < shape_.size.array() - 1).all();
  if (safe)
  {
    const std::ptrdiff_t stride[3] = {line.step[0],
                                      line.step[1] * static_cast<std::ptrdiff_t>(shape_.pitch()),
                                      line.step[2] * static_cast<std::ptrdiff_t>(shape_.row(0, 1))};
    std::uint8_t* mark = row(from.y(), from.z()) + from.x();
    const std::uint8_t* const last = row(to.y(), to.z()) + to.x();
    *mark |= kPassed;
    int axis = line.nearestAxis();
    for (;;)
    {
      mark += stride[axis];
      line.next[axis] += line.gap[axis];
      if (mark == last) return;
      axis = line.nearestAxis();
      if (line.next[axis] > line.length) return;
      *mark |= kPassed;
    }
  }
  Eigen::Vector3i cell = from;
  if (inside(cell)) row(cell.y(), cell.z())[cell.x()] |= kPassed;
  for (int axis = line.nearestAxis();;)
  {
    cell[axis] += line.step[axis];
    line.next[axis] += line.gap[axis];
    if (cell == to) return;
    axis = line.nearestAxis();
    if (line.next[axis] > line.length) return;
    if (inside(cell)) row(cell.y(), cell.z())[cell.x()] |= kPassed;
  }
}

}  // namespace slalom::mapping::detail
