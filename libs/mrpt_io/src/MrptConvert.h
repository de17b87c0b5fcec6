// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/poses/CPose3D.h>

#include <Eigen/Geometry>

namespace slalom::mrpt_io::detail
{
[[nodiscard]] inline Eigen::Isometry3d toEigen(const mrpt::poses::CPose3D& pose)
{
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  const auto& R = pose.getRotationMatrix();
  for (int i = 0; i < 3; ++i)
  {
    for (int j = 0; j < 3; ++j) T(i, j) = R(i, j);
    T(i, 3) = pose[static_cast<unsigned>(i)];
  }
  return T;
}

[[nodiscard]] inline mrpt::poses::CPose3D toMrpt(const Eigen::Isometry3d& T)
{
  mrpt::math::CMatrixDouble33 R;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) R(i, j) = T(i, j);
  return {R, mrpt::math::TPoint3D(T(0, 3), T(1, 3), T(2, 3))};
}

}  // namespace slalom::mrpt_io::detail
