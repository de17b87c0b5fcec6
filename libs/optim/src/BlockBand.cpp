// SPDX-License-Identifier: BSD-3-Clause
#include "slalom/optim/BlockBand.h"

#include <algorithm>

namespace slalom::optim
{
void BlockBand::setZero()
{
  for (auto* blocks : {&diagonal, &first, &second})
    std::fill(blocks->begin(), blocks->end(), Eigen::Matrix3d::Zero());
}

Eigen::Matrix3Xd BlockBand::times(const Eigen::Matrix3Xd& x) const
{
  const Eigen::Index n = blocks();
  Eigen::Matrix3Xd y(3, n);
  for (Eigen::Index k = 0; k < n; ++k) y.col(k) = diagonal[k] * x.col(k);
  for (Eigen::Index k = 0; k + 1 < n; ++k)
  {
    y.col(k + 1) += first[k] * x.col(k);
    y.col(k) += first[k].transpose() * x.col(k + 1);
  }
  for (Eigen::Index k = 0; !second.empty() && k + 2 < n; ++k)
  {
    y.col(k + 2) += second[k] * x.col(k);
    y.col(k) += second[k].transpose() * x.col(k + 2);
  }
  return y;
}

}  // namespace slalom::optim
