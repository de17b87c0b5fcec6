// SPDX-License-Identifier: BSD-3-Clause
#include "ArcLength.h"

#include <algorithm>

namespace slalom::search::detail
{
ArcLength::ArcLength(const Eigen::Matrix3Xd& path) : path_(path), up_to_{0.0}
{
  for (Eigen::Index i = 1; i < path.cols(); ++i)
    up_to_.push_back(up_to_.back() + (path.col(i) - path.col(i - 1)).norm());
}

Eigen::Vector3d ArcLength::at(double s) const
{
  const auto after = std::upper_bound(up_to_.begin(), up_to_.end(), s);
  if (after == up_to_.begin()) return path_.col(0);
  if (after == up_to_.end()) return path_.col(path_.cols() - 1);
  const Eigen::Index i = after - up_to_.begin();
  const double share = (s - *(after - 1)) / (*after - *(after - 1));
  return path_.col(i - 1) + share * (path_.col(i) - path_.col(i - 1));
}
}  // namespace slalom::search::detail
