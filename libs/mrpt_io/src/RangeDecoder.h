// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/obs/CObservation.h>

#include "Dropped.h"
#include "slalom/core/PointCloud.h"

namespace slalom::mrpt_io::detail
{
/// True for the classes that decodeRange() understands.
[[nodiscard]] bool isRangeObservation(const mrpt::obs::CObservation& observation);

/** Fills points (sensor axes, x forward, y left, z up), duration and mount of a range observation.
 *  Invalid returns are dropped and counted; points are not yet judged by range. */
void decodeRange(const mrpt::obs::CObservation& observation, core::RangeScan& out,
                 Dropped& dropped);

/// Removes points that are not finite, at the sensor itself, or outside [min, max] [m].
void filterRange(core::RangeScan& scan, double min, double max, Dropped& dropped);

}  // namespace slalom::mrpt_io::detail
