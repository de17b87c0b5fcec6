// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

namespace slalom::core
{
struct Sphere
{
  Eigen::Vector3d centre_L = Eigen::Vector3d::Zero();  ///< [m] local frame
  double radius_m = 0.0;                               ///< [m]
};

}  // namespace slalom::core
