// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <vector>

#include "slalom/core/HalfSpaces.h"

namespace slalom::geometry
{
/// Shape of the local box around a seed segment and the safety shrink of the planes.
struct DecompositionConfig
{
  double along_m = 1.0;     ///< [m] box beyond both ends, along the segment
  double lateral_m = 2.0;   ///< [m] box to both sides
  double vertical_m = 2.0;  ///< [m] box up and down
  double shrink_m =
      0.0;  ///< [m] every obstacle plane is moved inwards by this (radius + half voxel diagonal)
};

/// One convex free set around a segment.
struct FreePolyhedron
{
  core::HalfSpaces set;  ///< unit normals
  bool contains_seed =
      false;  ///< both ends satisfy the (shrunk) planes; false when an obstacle is too near
};

/** Largest-ellipsoid-first convex free set around the segment a-b: ellipsoid inflation, tangent
 * planes at the closest obstacles, then the local box (Liu et al. 2017). Degenerate input is legal:
 * a = b, obstacles on the segment, no obstacles. Results are finite and bounded.
 *
 *  Every point of the set keeps shrink_m from every obstacle point. contains_seed is true exactly
 * when the segment itself keeps shrink_m from all of them: where a shrunk tangent plane would cut
 * the segment, the plane across the shortest way from the segment to that obstacle takes its place.
 *  @param obstacles_L obstacle points (voxel centres); those outside the local box grown by
 * shrink_m, and those that are not finite, are ignored
 *  @throws std::invalid_argument on a non-finite end, a non-positive box or a negative shrink
 *  @see [Paper Sec. III-C] */
[[nodiscard]] FreePolyhedron decompose(const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                                       const std::vector<Eigen::Vector3d>& obstacles_L,
                                       const DecompositionConfig& config);

/// Axis-aligned box that encloses the local box of a segment, grown by shrink_m; what to collect
/// obstacles in.
[[nodiscard]] Eigen::AlignedBox3d localBox(const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                                           const DecompositionConfig& config);

/** Decomposes every edge of a polyline, one task per edge on `threads` threads (>= 1). Results are
 * written by index and do not depend on the number of threads.
 *  @param obstacles_per_edge one obstacle list per edge, size cols - 1
 *  @throws std::invalid_argument as decompose() does, and on another number of lists or threads < 1
 */
[[nodiscard]] std::vector<FreePolyhedron> decomposeParallel(
    const Eigen::Matrix3Xd& path,
    const std::vector<std::vector<Eigen::Vector3d>>& obstacles_per_edge,
    const DecompositionConfig& config, int threads);

/** Euclidean projection of x onto { A x <= b } [Paper Eq. (5), one point]. Exact (active set in
 * R^3); planes are kept to 1e-10 m per metre of x.
 *  @return nullopt if the set is empty, or x is not finite */
[[nodiscard]] std::optional<Eigen::Vector3d> project(const Eigen::Vector3d& x,
                                                     const core::HalfSpaces& set);

}  // namespace slalom::geometry
