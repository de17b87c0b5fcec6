// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "Axes.h"
#include "Canvas.h"
#include "FlightLog.h"

namespace slalom::report::detail
{
/// One quantity over log time. NaN = nothing there.
struct Series
{
  std::string label;           ///< empty: not in the legend
  std::vector<double> values;  ///< one per cycle
  Stroke stroke;
  bool dots = false;  ///< single events instead of a line
};

/// A horizontal line with a name.
struct Level
{
  std::string label;
  double value = 0.0;
  Stroke stroke;
};

struct Plot
{
  AxesStyle style;
  std::vector<Series> series;
  std::vector<Level>
      levels;  ///< drawn and named in the legend; those above the axis are named only
  double y_from = 0.0, y_to = 1.0;
  bool legend_on_own_line = false;  ///< between title and box; else right of the title
};

/// Draws the plot into `area` (the box of the data), title and legend above it. Gaps of more than
/// one second break a line.
void drawPlot(Canvas& canvas, cv::Rect area, const std::vector<double>& times, const Plot& plot);

/// Largest finite value; NaN when there is none.
[[nodiscard]] double largest(const std::vector<double>& values);
template <class Get>
[[nodiscard]] std::vector<double> seriesOf(const std::vector<CycleSummary>& cycles, Get get)
{
  std::vector<double> values;
  values.reserve(cycles.size());
  for (const CycleSummary& cycle : cycles) values.push_back(get(cycle));
  return values;
}

}  // namespace slalom::report::detail
