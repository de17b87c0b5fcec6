// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <optional>

#include "slalom/core/DistanceField.h"

namespace slalom::global_planner
{
/** Where to go first from a place that is too near to obstacles: a point with `clearance` at most
 * `reach` away, up the distance gradient or else the nearest of a grid around the place. On the
 * straight way there nothing comes nearer than it already is (to a quarter of a voxel). Optimistic
 * field.
 *  @return the place itself if it keeps `clearance`; nullopt if there is no such point, or the
 * place lies outside the field
 *  @see [Paper Sec. III-D, dead zone]; deviation D-16 (docs/paper_map.md) */
[[nodiscard]] std::optional<Eigen::Vector3d> findRetreat(const core::DistanceField& field,
                                                         const Eigen::Vector3d& place_L,
                                                         double clearance, double reach);

}  // namespace slalom::global_planner
