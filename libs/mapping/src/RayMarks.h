// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "DistanceTransform.h"
#include "LineTraversal.h"
#include "slalom/core/PointCloud.h"

namespace slalom::mapping::detail
{
/** Which cells of a window one scan saw: a byte per cell, cleared by its reader.
 *
 *  Semantics of octomap::OcTree::insertPointCloud(discretize = true): returns are merged per end
 * voxel, each such voxel is hit once, and a line from the sensor to its centre is traversed cell by
 * cell with OctoMap's rounding, so that the same cells result. A ray longer than the range is
 * replaced by one to the voxel that holds the point at that range, which is merged alike and makes
 * no hit. */
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
    int fused = 0, beyond_range = 0, free_only = 0;
  };

  /// @param window cells per axis
  RayMarks(const Eigen::Vector3i& window, double resolution, double min_range, double max_range);

  /** @param first_cell coordinates of cell (0,0,0) of the window in the lattice of all cells
   *  @param free_only one per ray: those that are not 0 clear up to their end and hit nothing; may
   *                   be shorter than `rays` */
  Count cast(const Eigen::Vector3i& first_cell, std::span<const core::Ray> rays,
             std::span<const std::uint8_t> free_only = {});

  /// Marks of a row of the window.
  [[nodiscard]] std::uint8_t* row(int y, int z) { return marks_.data() + offset({0, y, z}); }

  /// Clears what lies outside the window; the rows are cleared by whoever reads them.
  void clearMargin();

  [[nodiscard]] std::size_t bytes() const { return marks_.size(); }

 private:
  // The grid is larger than the window, which may be off the vehicle's centre by a brick: rays that
  // end at the range end inside the grid.
  static constexpr int kMargin = 8;

  [[nodiscard]] std::int64_t offset(const Eigen::Vector3i& cell) const
  {
    return static_cast<std::int64_t>(shape_.row(cell.y() + kMargin, cell.z() + kMargin)) +
           cell.x() + kMargin;
  }
  // Whether a cell is in the grid and at least `border` cells from its faces.
  [[nodiscard]] bool inside(const Eigen::Vector3i& cell, int border) const
  {
    const auto in = [&](int i, int n) { return i >= border - kMargin && i < n - kMargin - border; };
    return in(cell.x(), shape_.size.x()) && in(cell.y(), shape_.size.y()) &&
           in(cell.z(), shape_.size.z());
  }
  [[nodiscard]] Eigen::Vector3i cellOf(const Eigen::Vector3f& p_L) const;
  [[nodiscard]] Eigen::Vector3f centreOf(const Eigen::Vector3i& cell) const;
  void castLine(const Eigen::Vector3f& origin_L, const Eigen::Vector3i& end);
  void walk(GridLine& line, Eigen::Vector3i cell, const Eigen::Vector3i& end);

  GridShape shape_;
  double resolution_, cells_per_metre_, min_range_, max_range_;
  Eigen::Vector3i first_cell_ = Eigen::Vector3i::Zero();
  std::vector<std::uint8_t> marks_;  // and one spare byte
  std::vector<GridLine> lines_;      // waiting to be traversed
};

}  // namespace slalom::mapping::detail
