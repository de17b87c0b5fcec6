// SPDX-License-Identifier: BSD-3-Clause
#include "Geometry2d.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace slalom::report::detail
{
Polygon clip(const Polygon& convex, const Eigen::Vector2d& normal, double offset)
{
  Polygon kept;
  for (std::size_t i = 0; i < convex.size(); ++i)
  {
    const Eigen::Vector2d& a = convex[i];
    const Eigen::Vector2d& b = convex[(i + 1) % convex.size()];
    const double over_a = normal.dot(a) - offset, over_b = normal.dot(b) - offset;
    if (over_a <= 0.0) kept.push_back(a);
    if ((over_a < 0.0 && over_b > 0.0) || (over_a > 0.0 && over_b < 0.0))
      kept.emplace_back(a + over_a / (over_a - over_b) * (b - a));
  }
  return kept.size() >= 3 ? kept : Polygon{};
}

Polygon horizontalSlice(const core::HalfSpaces& body, double z, const Eigen::Vector2d& lo,
                        const Eigen::Vector2d& hi)
{
  Polygon slice = {lo, {hi.x(), lo.y()}, hi, {lo.x(), hi.y()}};
  for (Eigen::Index i = 0; i < body.rows() && !slice.empty(); ++i)
    slice = clip(slice, body.A.row(i).head<2>(), body.b[i] - body.A(i, 2) * z);
  return slice;
}

double headingAt(const core::Polyline& line, const Eigen::Vector3d& p)
{
  double nearest = std::numeric_limits<double>::infinity(), heading = 0.0;
  for (Eigen::Index i = 1; i < line.cols(); ++i)
  {
    const Eigen::Vector3d a = line.col(i - 1), step = line.col(i) - line.col(i - 1);
    const double length2 = step.squaredNorm();
    if (!(step.head<2>().squaredNorm() > 1e-12)) continue;
    const double share = std::clamp(step.dot(p - a) / length2, 0.0, 1.0);
    const double distance = (a + share * step - p).squaredNorm();
    if (distance >= nearest) continue;
    nearest = distance;
    heading = std::atan2(step.y(), step.x());
  }
  return heading;
}

Eigen::Vector2d clampToBox(const Eigen::Vector2d& inside, const Eigen::Vector2d& target,
                           const Eigen::Vector2d& lo, const Eigen::Vector2d& hi)
{
  double share = 1.0;
  for (int axis = 0; axis < 2; ++axis)
  {
    const double step = target[axis] - inside[axis];
    if (step > 0.0) share = std::min(share, (hi[axis] - inside[axis]) / step);
    if (step < 0.0) share = std::min(share, (lo[axis] - inside[axis]) / step);
  }
  return inside + std::max(share, 0.0) * (target - inside);
}

}  // namespace slalom::report::detail
