// SPDX-License-Identifier: BSD-3-Clause
#include "SeriesPlot.h"

#include <algorithm>
#include <cmath>

#include "Legend.h"
#include "Style.h"

namespace slalom::report::detail
{
namespace
{
constexpr double kLineGapS = 1.0;

void drawSeries(Canvas& canvas, const Axes& axes, const std::vector<double>& times,
                const Series& series)
{
  PixelPath piece;
  double last_t = 0.0;
  const auto finishPiece = [&]
  {
    if (piece.size() == 1) canvas.disc(piece.front(), 1.5, series.stroke.colour);
    canvas.path(piece, series.stroke);
    piece.clear();
  };
  for (std::size_t i = 0; i < series.values.size(); ++i)
  {
    // Parts that do not run in every cycle still make one line; only a pause breaks it.
    if (!std::isfinite(series.values[i])) continue;
    const Pixel p = axes.toPixel(times[i], series.values[i]);
    if (series.dots)
    {
      canvas.disc(p, 1.8, series.stroke.colour);
      continue;
    }
    if (!piece.empty() && times[i] - last_t > kLineGapS) finishPiece();
    last_t = times[i];
    piece.push_back(p);
  }
  finishPiece();
}

LegendEntry dotEntry(std::string label, Colour colour)
{
  return {std::move(label), [colour](Canvas& canvas, cv::Rect box)
          {
            for (const double share : {0.25, 0.5, 0.75})
              canvas.disc({box.x + share * box.width, box.y + 0.5 * box.height}, 1.8, colour);
          }};
}
}  // namespace

double largest(const std::vector<double>& values)
{
  double top = kNone;
  for (const double value : values)
    if (std::isfinite(value)) top = std::fmax(top, value);
  return top;
}

void drawPlot(Canvas& canvas, cv::Rect area, const std::vector<double>& times, const Plot& plot)
{
  Axes axes{area, 0.0, 1.0, plot.y_from, plot.y_to};
  if (!times.empty()) axes.x0 = times.front(), axes.x1 = std::max(times.back(), axes.x0 + 1.0);
  drawGrid(canvas, axes, plot.style);
  Canvas inside = canvas.clipped(area);
  std::vector<LegendEntry> legend;
  bool any = false;
  for (const Series& series : plot.series)
  {
    if (!std::isfinite(largest(series.values))) continue;
    any = true;
    drawSeries(inside, axes, times, series);
    if (series.label.empty()) continue;
    legend.push_back(series.dots ? dotEntry(series.label, series.stroke.colour)
                                 : lineEntry(series.label, series.stroke));
  }
  for (const Level& level : plot.levels)
  {
    const bool shown = level.value <= plot.y_to && level.value >= plot.y_from;
    if (shown)
      inside.line(axes.toPixel(axes.x0, level.value), axes.toPixel(axes.x1, level.value),
                  level.stroke);
    legend.push_back(lineEntry(level.label + (shown ? "" : " (off scale)"), level.stroke));
  }
  if (!any)
    canvas.text({area.x + 0.5 * area.width, area.y + 0.5 * area.height}, "no data",
                {1.2 * plot.style.font_size}, style::kFaint, Align::Centre);
  AxesStyle frame = plot.style;
  if (plot.legend_on_own_line) frame.title.clear();
  drawFrame(canvas, axes, frame);
  if (plot.legend_on_own_line)
    canvas.text({double(area.x), area.y - 2.05 * plot.style.font_size}, plot.style.title,
                {1.1 * plot.style.font_size, true}, style::kInk);
  drawLegendRow(canvas, {double(area.x + area.width), area.y - 0.55 * plot.style.font_size}, legend,
                0.92 * plot.style.font_size);
}

}  // namespace slalom::report::detail
