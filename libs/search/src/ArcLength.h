// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <vector>

namespace slalom::search::detail
{
/// A polyline by arc length. Asked in ascending or any order; keeps a reference to the path.
class ArcLength
{
 public:
  explicit ArcLength(const Eigen::Matrix3Xd& path);

  [[nodiscard]] double length() const { return up_to_.back(); }
  /// Point at arc length s, which is cut to [0, length()].
  [[nodiscard]] Eigen::Vector3d at(double s) const;

 private:
  const Eigen::Matrix3Xd& path_;
  std::vector<double> up_to_;  ///< [m] arc length of each point
};
}  // namespace slalom::search::detail
