// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>

namespace slalom::simulation
{
/// A trunk: a solid vertical cylinder that stands on z = base.
struct Tree
{
  Eigen::Vector2d centre_W = Eigen::Vector2d::Zero();  ///< [m]
  double radius = 0.3;                                 ///< [m] > 0
  double height = 8.0;                                 ///< [m] > 0
  double base = 0.0;                                   ///< [m] of its foot
};

/// A solid ball.
struct Sphere
{
  Eigen::Vector3d centre_W = Eigen::Vector3d::Zero();  ///< [m]
  double radius = 0.5;                                 ///< [m] > 0
};

/// A solid box with its faces along the axes, world frame [m].
using Box = Eigen::AlignedBox3d;

}  // namespace slalom::simulation
