// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "Solids.h"
#include "VoxelGrid.h"

namespace slalom::simulation::detail
{
/** A dense grid of solid voxels. Rays leap over the empty cube around each voxel they visit (chess
 * board distance), distances are found by branch and bound in a pyramid of occupancy flags; both
 * are exact for the set of voxels. */
class VoxelSolids : public Solids
{
 public:
  /// @pre made by rasterize(): padded on every side, at least one solid voxel
  explicit VoxelSolids(const VoxelGrid& grid);

  [[nodiscard]] std::optional<double> castRay(const Eigen::Vector3d& origin,
                                              const Eigen::Vector3d& direction,
                                              double max_range) const override;
  [[nodiscard]] double distance(const Eigen::Vector3d& p) const override;
  [[nodiscard]] Eigen::AlignedBox3d bounds() const override;  ///< without the padding

 private:
  struct Level
  {
    Eigen::Vector3i size;
    std::vector<std::uint8_t> flags;  // kHasSolid, kHasEmpty
  };
  struct Search;

  void computeLeaps(const VoxelGrid& grid);
  void buildPyramid();
  [[nodiscard]] std::uint8_t flagsAt(std::size_t level, const Eigen::Vector3i& cell) const;
  void descend(std::size_t level, const Eigen::Vector3i& cell, Search& search) const;
  [[nodiscard]] std::size_t index(const Eigen::Vector3i& cell) const
  {
    return (static_cast<std::size_t>(cell.z()) * static_cast<std::size_t>(size_.y()) +
            static_cast<std::size_t>(cell.y())) *
               static_cast<std::size_t>(size_.x()) +
           static_cast<std::size_t>(cell.x());
  }

  Eigen::Vector3d corner_W_;  // lower corner of voxel (0, 0, 0) [m]
  Eigen::Vector3i size_;
  double resolution_;
  std::vector<std::uint8_t> leap_;  // chess board distance to the nearest solid voxel, saturated
  std::vector<Level> pyramid_;      // pyramid_[k] has blocks of 2^(k+1) voxels
};

}  // namespace slalom::simulation::detail
