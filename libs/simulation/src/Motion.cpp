// SPDX-License-Identifier: BSD-3-Clause
#include "slalom/simulation/Motion.h"

#include <cmath>

namespace slalom::simulation
{
Eigen::Quaterniond hoverAttitude(const Eigen::Vector3d& a_W, double yaw)
{
  const Eigen::Vector3d z = (a_W + Eigen::Vector3d(0.0, 0.0, kGravity)).normalized();
  const double c = std::cos(yaw), s = std::sin(yaw);
  // The vector above heading `yaw` that is normal to the thrust.
  const Eigen::Vector3d x = Eigen::Vector3d(c, s, -(c * z.x() + s * z.y()) / z.z()).normalized();
  Eigen::Matrix3d axes;
  axes << x, z.cross(x), z;
  return Eigen::Quaterniond(axes);
}

}  // namespace slalom::simulation
