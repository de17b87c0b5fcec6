// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "DistanceTransform.h"
#include "slalom/core/DistanceField.h"

namespace slalom::mapping::detail
{
/** A number that the distance from the convex hull of four points to every obstacle cube of a grid
 * is proved not to be below, at most `limit`; exact for four equal points.
 *  @param field signed squared distances as DistanceTransform makes them
 *  @param hull [voxel] from the grid's corner; cell (i, j, k) is the cube [i, i + 1] x ..
 *  @param limit [voxel] > 0 and finite
 *  @param saturation |field| from this value on is cut off
 *  @return [voxel] */
[[nodiscard]] double distanceToCubes(const GridShape& shape, const std::int16_t* field,
                                     const core::Hull4& hull, double limit, int saturation);

}  // namespace slalom::mapping::detail
