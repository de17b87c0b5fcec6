// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <vector>

#include "slalom/geometry/ConvexDecomposition.h"

namespace slalom::geometry::detail
{
/// Frame of a segment: origin in its middle, x along it, y horizontal where that is possible.
struct SegmentFrame
{
  SegmentFrame(const Eigen::Vector3d& a, const Eigen::Vector3d& b,
               const DecompositionConfig& config);

  Eigen::Vector3d middle;
  Eigen::Matrix3d axes;      ///< columns: x, y, z of the segment in L
  Eigen::Vector3d half_box;  ///< [m] of the local box along those axes
  double half_length;        ///< [m]
};

/// Plane { n.p = offset } in the segment's frame; free space is n.p <= offset.
struct LocalPlane
{
  Eigen::Vector3d normal;
  double offset;
};

/// Obstacles in the segment's frame, one array per coordinate, of which the first `count` entries
/// are valid. The arrays only grow, and are reused from edge to edge.
struct Scratch
{
  std::vector<double> x, y, z, metric;
  std::size_t count = 0;
  std::vector<LocalPlane> planes;
};

[[nodiscard]] FreePolyhedron freePolyhedron(const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                                            const std::vector<Eigen::Vector3d>& obstacles_L,
                                            const DecompositionConfig& config, Scratch& scratch);
}  // namespace slalom::geometry::detail
