// SPDX-License-Identifier: BSD-3-Clause
#include "slalom/global_planner/GradientVectors.h"

#include <limits>

namespace slalom::global_planner
{
std::optional<Eigen::Vector3d> crossing(const Eigen::Vector3d& before, const Eigen::Vector3d& at,
                                        const Eigen::Vector3d& after, const Eigen::Matrix3Xd& path)
{
  const Eigen::Vector3d v1 = after - before;
  if (v1.norm() < 1e-9) return std::nullopt;
  std::optional<Eigen::Vector3d> nearest;
  double nearest_distance = std::numeric_limits<double>::infinity();
  for (Eigen::Index k = 0; k + 1 < path.cols(); ++k)
  {
    const Eigen::Vector3d edge = path.col(k + 1) - path.col(k);
    const double along = v1.dot(edge);
    const double missing = v1.dot(at - path.col(k));
    if (along == 0.0) continue;
    const double t = missing / along;
    if (t < 0.0 || t > 1.0) continue;
    const Eigen::Vector3d point = path.col(k) + t * edge;
    const double distance = (point - at).norm();
    if (distance < nearest_distance)
    {
      nearest_distance = distance;
      nearest = point;
    }
  }
  return nearest;
}

}  // namespace slalom::global_planner
