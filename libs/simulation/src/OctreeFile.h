// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <vector>

namespace slalom::simulation::detail
{
/// A cube of 2^k voxels on a side. Voxel (0, 0, 0) has its lower corner in the world's origin.
struct OctreeLeaf
{
  Eigen::Vector3i corner;  ///< lowest voxel
  int edge;                ///< [voxels]
  bool occupied;           ///< else known to be free
};

struct OctreeLeaves
{
  double resolution = 0.0;  ///< [m]
  std::vector<OctreeLeaf> leaves;
};

/** The known leaves of an OctoMap file, binary (.bt) or full (.ot, tree id OcTree), by content.
 *  Own reader because liboctomap follows the child flags of a damaged file without bounds.
 *  @throws std::runtime_error naming the file and what is wrong */
[[nodiscard]] OctreeLeaves readOctree(const std::filesystem::path& file);

}  // namespace slalom::simulation::detail
