// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "slalom/core/DistanceField.h"
#include "slalom/spline/UniformBSpline.h"

namespace slalom::global_planner
{
/// A stretch of the curve nearer to obstacles than allowed, widened to where the curve is free
/// again.
struct OccupiedSegment
{
  double from = 0.0;        ///< [s] last free parameter before it
  double to = 0.0;          ///< [s] first free parameter behind it
  bool open_start = false;  ///< the curve is not free at the start of the window
  bool open_end = false;    ///< the curve is not free at the end of the window
};

/** CheckingOccupiedSegments [Paper Algorithm 1, line 3], on the curve and not on its control
 * points: marches in steps that the distance field allows (no stretch longer than half a voxel is
 * skipped), optimistic field; space outside the map is not occupied. Segments whose gap is shorter
 * than `merge_gap` [s] become one.
 *  @param clearance distance below which the curve counts as occupied [m] */
[[nodiscard]] std::vector<OccupiedSegment> findOccupiedSegments(const spline::UniformBSpline& curve,
                                                                double from, double to,
                                                                const core::DistanceField& field,
                                                                double clearance, double merge_gap);

/// Smallest optimistic distance along the curve, sampled every half voxel [m]; saturated at the
/// field's maximum.
[[nodiscard]] double minClearance(const spline::UniformBSpline& curve, double from, double to,
                                  const core::DistanceField& field);

}  // namespace slalom::global_planner
