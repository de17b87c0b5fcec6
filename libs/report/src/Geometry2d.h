// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <vector>

#include "slalom/core/CycleRecord.h"
#include "slalom/core/HalfSpaces.h"

namespace slalom::report::detail
{
using Polygon = std::vector<Eigen::Vector2d>;  ///< corners in order [m]; empty = no area

/// Part of a convex polygon where normal . p <= offset (Sutherland and Hodgman, 1974).
[[nodiscard]] Polygon clip(const Polygon& convex, const Eigen::Vector2d& normal, double offset);

/// Cut of { A x <= b } with the plane z = `z`, inside the box [lo, hi]; counter-clockwise.
[[nodiscard]] Polygon horizontalSlice(const core::HalfSpaces& body, double z,
                                      const Eigen::Vector2d& lo, const Eigen::Vector2d& hi);

/// Heading of the line at its point nearest to `p` [rad]; 0 for lines without a direction.
[[nodiscard]] double headingAt(const core::Polyline& line, const Eigen::Vector3d& p);

/// Where the segment from `inside` to `target` leaves the box; `target` itself if it is inside.
[[nodiscard]] Eigen::Vector2d clampToBox(const Eigen::Vector2d& inside,
                                         const Eigen::Vector2d& target, const Eigen::Vector2d& lo,
                                         const Eigen::Vector2d& hi);

}  // namespace slalom::report::detail
