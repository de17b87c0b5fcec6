// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "OctreeFile.h"

namespace slalom::simulation::detail
{
enum class Voxel : std::uint8_t
{
  Unknown,
  Free,
  Solid
};

/// A dense box of voxels, x fastest.
struct VoxelGrid
{
  Eigen::Vector3i corner = Eigen::Vector3i::Zero();  ///< voxel of the world at index (0, 0, 0)
  Eigen::Vector3i size = Eigen::Vector3i::Zero();
  double resolution = 0.0;
  std::vector<Voxel> voxels;

  [[nodiscard]] std::size_t index(int x, int y, int z) const
  {
    return (static_cast<std::size_t>(z) * static_cast<std::size_t>(size.y()) +
            static_cast<std::size_t>(y)) *
               static_cast<std::size_t>(size.x()) +
           static_cast<std::size_t>(x);
  }
};

/// Empty voxels around the occupied ones on every side; floods start there.
inline constexpr int kPadding = 2;

/** The box of the occupied leaves with kPadding voxels around, filled in from the leaves.
 *  @throws std::runtime_error if it has no occupied leaf or more than 500 million voxels */
[[nodiscard]] VoxelGrid rasterize(const OctreeLeaves& tree);

/** Turns unknown voxels that shells enclose into solid. Known-free voxels stay free.
 *
 *  Scanned maps show trunks as tubes: open above and below, often with gaps. So besides what no
 * path from outside or from free space reaches (closed shells), every horizontal slice is flooded
 * from outside and from free space: a hole of at most the area of the thickest trunk (1.5 m across)
 * that the flood does not reach is solid. A second flood runs with the shells thickened by one
 * voxel, which closes gaps of up to two voxels; it fills only holes wide enough to hold 3 x 3
 * voxels, so twigs near each other do not grow together. Last, short unfilled stretches (0.5 m)
 * between two filled parts of a column are filled. */
void fillShells(VoxelGrid& grid);

}  // namespace slalom::simulation::detail
