// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "DistanceTransform.h"
#include "slalom/core/PointCloud.h"

namespace slalom::mapping::detail
{
/** Which cells of a window one scan saw: a byte per cell, cleared by its reader.
 *
 *  Semantics of octomap::OcTree::insertPointCloud(discretize = true): returns are merged per end
 * voxel, each such voxel is hit once, and a line from the sensor to its centre is traversed cell by
 * cell (Amanatides and Woo, 1987, with OctoMap's rounding, so that the same cells result). A ray
 * longer than the range is replaced by one to the voxel that holds the point at that range, which
 * is merged alike and makes no hit. */
class RayMarks
{
 public:
  enum Bits : std::uint8_t
  {
    kPassed = 1,
    kHit = 2,
    kCast = 4  ///< a ray to this voxel has been traversed already
  };
  static constexpr std::uint8_t kSeen = kPassed | kHit;

  struct Count
  {
    int fused = 0, beyond_range = 0;
  };

  RayMarks(const GridShape& shape, double resolution, double min_range, double max_range);

  /// @param first_cell coordinates of cell (0,0,0) of the window in the lattice of all cells
  Count cast(const Eigen::Vector3i& first_cell, std::span<const core::Ray> rays);

  [[nodiscard]] std::uint8_t* row(int y, int z) { return marks_.data() + shape_.row(y, z); }
  [[nodiscard]] const GridShape& shape() const { return shape_; }
  [[nodiscard]] std::size_t bytes() const { return marks_.size(); }

  /// Cell that holds a point, in the lattice with a corner at the origin.
  [[nodiscard]] Eigen::Vector3i cellOf(const Eigen::Vector3f& p_L) const
  {
    return (p_L.cast<double>() * cells_per_metre_).array().floor().cast<int>();
  }

 private:
  [[nodiscard]] bool inside(const Eigen::Vector3i& cell) const
  {
    return (cell.array() >= 0).all() && (cell.array() < shape_.size.array()).all();
  }
  void traverse(const Eigen::Vector3f& origin_L, const Eigen::Vector3f& end_L,
                const Eigen::Vector3i& from, const Eigen::Vector3i& to);

  GridShape shape_;
  double resolution_, cells_per_metre_, min_range_, max_range_;
  Eigen::Vector3i first_cell_ = Eigen::Vector3i::Zero();
  std::vector<std::uint8_t> marks_;
};

}  // namespace slalom::mapping::detail
