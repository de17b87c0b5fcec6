// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "Canvas.h"

namespace slalom::report::detail
{
/// Tick positions at 1, 2 or 5 times a power of ten, inside [lo, hi], at most max_count.
struct Ticks
{
  std::vector<double> values;
  double step = 1.0;
  [[nodiscard]] std::string label(double value) const;  ///< with the decimals that step needs
};
[[nodiscard]] Ticks niceTicks(double lo, double hi, int max_count);

/// A rectangle of pixels that shows a range of data, y upwards.
struct Axes
{
  cv::Rect area;
  double x0 = 0.0, x1 = 1.0, y0 = 0.0, y1 = 1.0;

  /// Equal scale on both axes: widens the shorter range around its middle to fill `area`.
  [[nodiscard]] static Axes equalScale(cv::Rect area, Eigen::Vector2d lo, Eigen::Vector2d hi);

  [[nodiscard]] Pixel toPixel(double x, double y) const;
  [[nodiscard]] Pixel toPixel(const Eigen::Vector2d& p) const { return toPixel(p.x(), p.y()); }
  [[nodiscard]] double pixelsPerUnit() const { return area.width / (x1 - x0); }
};

struct AxesStyle
{
  std::string title, x_label, y_label;
  double font_size = 14.0;
  bool grid = true;
  bool x_tick_labels = true;
};

/// Background and grid, below the data.
void drawGrid(Canvas& canvas, const Axes& axes, const AxesStyle& style);
/// Frame, ticks, numbers, labels, title: above the data.
void drawFrame(Canvas& canvas, const Axes& axes, const AxesStyle& style);
/// A bar of a round number of metres with its length, lower left corner at `at`.
void drawScaleBar(Canvas& canvas, const Axes& axes, Pixel at, double font_size);

/// [0, m] with m a little above the largest finite value (or `at_least`).
[[nodiscard]] double roundedTop(double largest, double at_least);

}  // namespace slalom::report::detail
