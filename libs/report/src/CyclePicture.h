// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "Canvas.h"
#include "FlightLog.h"
#include "Legend.h"
#include "slalom/core/CycleRecord.h"
#include "slalom/report/ReportConfig.h"
#include "slalom/report/RunInfo.h"

namespace slalom::report::detail
{
/// Everything one cycle picture shows.
struct CycleView
{
  const core::CycleRecord& record;
  const std::vector<CycleSummary>& flown;  ///< up to and with this cycle
  const RunInfo& info;
  const ReportConfig& config;
};

/** What the engine knew, wanted and commanded in one cycle, seen from above: the distance field at
 * the vehicle's altitude with everything the planners made on it, and a panel with words and
 * numbers. */
[[nodiscard]] Canvas drawCyclePicture(const CycleView& view);

/// Upper end of the distance colours [m].
[[nodiscard]] double distanceScale(const core::CycleRecord& record);
/// Every item a cycle picture can show.
[[nodiscard]] std::vector<LegendEntry> cycleLegend();
/// Words, numbers, colour bar and legend beside the map.
void drawCyclePanel(Canvas& canvas, cv::Rect area, const CycleView& view, double font_size);
/// The symbol of goal or start: a ring with a filled core.
void drawPlace(Canvas& canvas, Pixel at, Colour colour, double radius);
/// A disc of the vehicle's radius with its heading.
void drawVehicle(Canvas& canvas, Pixel at, double radius, double yaw);

}  // namespace slalom::report::detail
