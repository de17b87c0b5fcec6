// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <vector>

namespace slalom::optim::detail
{
/** Symmetric block-pentadiagonal matrix of 3x3 blocks: diagonal[k] = (k,k), first[k] = (k+1,k),
 * second[k] = (k+2,k). */
struct BlockBand
{
  explicit BlockBand(Eigen::Index blocks)
      : diagonal(blocks, Eigen::Matrix3d::Zero()),
        first(blocks, Eigen::Matrix3d::Zero()),
        second(blocks, Eigen::Matrix3d::Zero())
  {
  }
  [[nodiscard]] Eigen::Index blocks() const { return static_cast<Eigen::Index>(diagonal.size()); }
  /// y = M x, one block per column.
  [[nodiscard]] Eigen::Matrix3Xd times(const Eigen::Matrix3Xd& x) const;

  std::vector<Eigen::Matrix3d> diagonal, first, second;
};

/// M = L L^T within the band: O(blocks) time and memory.
class BlockBandCholesky
{
 public:
  explicit BlockBandCholesky(Eigen::Index blocks) : factor_(blocks) {}
  /// False if a pivot is not positive (the factor is then useless).
  [[nodiscard]] bool compute(const BlockBand& matrix);
  /// Overwrites x by M^-1 x.
  void solveInPlace(Eigen::Matrix3Xd& x) const;

 private:
  BlockBand factor_;  // lower triangles on the diagonal
};

}  // namespace slalom::optim::detail
