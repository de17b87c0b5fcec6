// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

#include "slalom/optim/BlockBand.h"

namespace slalom::optim::detail
{
using optim::BlockBand;

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
