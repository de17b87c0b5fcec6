// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "slalom/search/GridSearch.h"

namespace slalom::search
{
/** Up to `max_paths` paths that pass obstacles on different sides, pairwise not deformable().
 *
 *  The first is what findPath() returns, whatever its status. The others follow from cheap to dear;
 * none costs more than config.max_detour times the first, but as each is near-optimal only, one may
 * be a few per cent cheaper than the first. They are found by closing the narrowest passages of a
 * path, one at a time, across the whole passage as far as one can see from the path, and searching
 * again: what then is found is the best way that does not use this passage. At most four passages
 * per path are tried, so that not every class is found where there are many. Over and under count
 * as well as left and right. All searches together expand at most config.max_expansions points.
 * Deterministic, thread-safe.
 *  @throws std::invalid_argument like findPath(), or if max_paths is not in 1..3 */
[[nodiscard]] std::vector<SearchResult> findDistinctPaths(
    const core::DistanceField& field, const Eigen::Vector3d& start_L, const Eigen::Vector3d& goal_L,
    const Eigen::AlignedBox3d& box_L, const GridSearchConfig& config, int max_paths);

/** Uniform visibility deformation: true if the points of both paths at equal shares of their length
 * see each other with the clearance, sampled at least once per voxel. Paths of different classes
 * are not deformable; but paths of one class may not be, if they bend far apart.
 *  @param a_L,b_L 3xN polylines, N >= 1, one point per column, with common ends */
[[nodiscard]] bool deformable(const core::DistanceField& field, const Eigen::Matrix3Xd& a_L,
                              const Eigen::Matrix3Xd& b_L, double clearance_m);

}  // namespace slalom::search
