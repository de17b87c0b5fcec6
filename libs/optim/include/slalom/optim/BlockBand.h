// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <vector>

namespace slalom::optim
{
/** Symmetric banded matrix of 3x3 blocks: diagonal[k] = (k,k), first[k] = (k+1,k), second[k] =
 * (k+2,k). With a band of 1 (block-tridiagonal) `second` is empty; the blocks that would lie
 * outside of the matrix, the last of `first` and the last two of `second`, are not used. It is the
 * Hessian of anything that couples each point of a path with its next neighbours. */
struct BlockBand
{
  explicit BlockBand(Eigen::Index blocks, Eigen::Index band = 2)
      : diagonal(blocks, Eigen::Matrix3d::Zero()),
        first(blocks, Eigen::Matrix3d::Zero()),
        second(band > 1 ? blocks : 0, Eigen::Matrix3d::Zero())
  {
  }
  [[nodiscard]] Eigen::Index blocks() const { return static_cast<Eigen::Index>(diagonal.size()); }
  void setZero();
  /// y = M x, one block per column.
  [[nodiscard]] Eigen::Matrix3Xd times(const Eigen::Matrix3Xd& x) const;

  std::vector<Eigen::Matrix3d> diagonal, first, second;
};

}  // namespace slalom::optim
