// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <vector>

namespace slalom::optim::detail
{
/** Symmetric banded matrix of 3x3 blocks: diagonal[k] = (k,k), first[k] = (k+1,k), second[k] =
 * (k+2,k). With a band of 1 (block-tridiagonal) `second` is empty. */
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

  std::vector<Eigen::Matrix3d> diagonal, first, second;
};

/// M = L L^T within the band: O(blocks) time and memory.
class BlockBandCholesky
{
 public:
  explicit BlockBandCholesky(Eigen::Index blocks, Eigen::Index band = 2) : factor_(blocks, band) {}
  /// False if a pivot is not positive (the factor is then useless).
  [[nodiscard]] bool compute(const BlockBand& matrix);
  /// Overwrites x by M^-1 x.
  void solveInPlace(Eigen::Matrix3Xd& x) const;

 private:
  BlockBand factor_;  // lower triangles on the diagonal, their own diagonals inverted
};

}  // namespace slalom::optim::detail
