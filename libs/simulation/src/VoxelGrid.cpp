// SPDX-License-Identifier: BSD-3-Clause
#include "VoxelGrid.h"

#include <algorithm>
#include <limits>
#include <stdexcept>
#include <string>

namespace slalom::simulation::detail
{
VoxelGrid rasterize(const OctreeLeaves& tree)
{
  constexpr std::int64_t kMaxVoxels = 500'000'000;
  Eigen::Vector3i lo = Eigen::Vector3i::Constant(std::numeric_limits<int>::max());
  Eigen::Vector3i hi = Eigen::Vector3i::Constant(std::numeric_limits<int>::min());
  for (const OctreeLeaf& leaf : tree.leaves)
  {
    if (!leaf.occupied) continue;
    lo = lo.cwiseMin(leaf.corner);
    hi = hi.cwiseMax((leaf.corner.array() + leaf.edge).matrix());
  }
  if (lo.x() > hi.x()) throw std::runtime_error("the octree has no occupied voxel");

  VoxelGrid grid;
  grid.resolution = tree.resolution;
  grid.corner = lo.array() - kPadding;
  grid.size = (hi - lo).array() + 2 * kPadding;
  const Eigen::Matrix<std::int64_t, 3, 1> size = grid.size.cast<std::int64_t>();
  if (size.prod() > kMaxVoxels)
    throw std::runtime_error("the octree spans " + std::to_string(size.prod()) +
                             " voxels, at most " + std::to_string(kMaxVoxels) + " can be held");
  grid.voxels.assign(static_cast<std::size_t>(size.prod()), Voxel::Unknown);
  for (const OctreeLeaf& leaf : tree.leaves)
  {
    const Eigen::Vector3i from = (leaf.corner - grid.corner).cwiseMax(0);
    const Eigen::Vector3i to =
        ((leaf.corner - grid.corner).array() + leaf.edge).matrix().cwiseMin(grid.size);
    const Voxel value = leaf.occupied ? Voxel::Solid : Voxel::Free;
    if (from.x() >= to.x()) continue;
    for (int z = from.z(); z < to.z(); ++z)
      for (int y = from.y(); y < to.y(); ++y)
        std::fill_n(grid.voxels.begin() + static_cast<std::ptrdiff_t>(grid.index(from.x(), y, z)),
                    to.x() - from.x(), value);
  }
  return grid;
}

}  // namespace slalom::simulation::detail
