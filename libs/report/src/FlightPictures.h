// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "Canvas.h"
#include "FlightLog.h"
#include "MapAccumulator.h"
#include "SeriesPlot.h"
#include "slalom/report/FlightMetrics.h"
#include "slalom/report/RunInfo.h"

namespace slalom::report::detail
{
/// What the pictures of a whole flight are drawn from.
struct FlightView
{
  const FlightLog& log;
  const FlightMetrics& metrics;
  const MapAccumulator& map;
  const RunInfo& info;
  const RunSummary& summary;
};

/// Whole flight from above: map, R, refined parts, flown path coloured by speed, truth, start,
/// goal.
[[nodiscard]] Canvas drawOverview(const FlightView& view);
/// Wall time of every part of the cycle over log time.
[[nodiscard]] Canvas drawTiming(const FlightView& view);
/// Errors, speed, clearance and altitude over log time.
[[nodiscard]] Canvas drawTracking(const FlightView& view);
/// Flown, wanted and refined altitude over log time.
[[nodiscard]] Plot altitudePlot(const FlightView& view);

}  // namespace slalom::report::detail
