// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "Canvas.h"

namespace slalom::report::detail
{
/// One line of a legend: a sample drawn by the same strokes as the picture, and what it means.
struct LegendEntry
{
  std::string label;
  std::function<void(Canvas&, cv::Rect)> draw;  ///< into the sample's box
};

[[nodiscard]] LegendEntry lineEntry(std::string label, Stroke stroke);

/// Draws the entries below each other from `top_left`; returns the height used [px].
double drawLegend(Canvas& canvas, Pixel top_left, const std::vector<LegendEntry>& entries,
                  double font_size);
/// Draws the entries on one line; `right_baseline` is its right end.
void drawLegendRow(Canvas& canvas, Pixel right_baseline, const std::vector<LegendEntry>& entries,
                   double font_size);

}  // namespace slalom::report::detail
