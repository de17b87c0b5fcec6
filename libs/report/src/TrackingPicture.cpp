// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <cmath>

#include "FlightPictures.h"
#include "RowFiles.h"
#include "SeriesPlot.h"
#include "Style.h"

namespace slalom::report::detail
{
namespace
{
constexpr double kFontSize = 14.0;
const Stroke kBlue{{31, 119, 180}, 2}, kOrange{{240, 120, 10}, 2}, kGreen{{44, 150, 60}, 2};
const Stroke kLimit{{214, 39, 40}, 2, {}, 8.0, 5.0}, kWish{{110, 110, 110}, 1, {}, 8.0, 5.0};

std::string withStatistics(const char* name, const Distribution& d)
{
  if (d.n == 0) return name;
  return std::string(name) + " (mean " + fixedNumber(*d.mean, 2) + ", p95 " +
         fixedNumber(*d.p95, 2) + ", max " + fixedNumber(*d.max, 2) + ")";
}

double topOf(const std::vector<Series>& series, double at_least)
{
  double top = at_least;
  for (const Series& s : series) top = std::fmax(top, largest(s.values));
  return roundedTop(top, at_least);
}

Plot errorPlot(const FlightView& view)
{
  const std::vector<CycleSummary>& cycles = view.log.cycles();
  const FlightMetrics& m = view.metrics;
  Plot plot;
  plot.style.title = "Tracking error";
  plot.style.y_label = "error [m]";
  plot.series = {{withStatistics("to R", m.vs_reference_m),
                  seriesOf(cycles, [](const auto& c) { return c.vs_reference_m; }), kBlue},
                 {withStatistics("to the setpoint", m.vs_setpoint_m),
                  seriesOf(cycles, [](const auto& c) { return c.vs_setpoint_m; }), kOrange},
                 {withStatistics("estimate to truth", m.estimate_error_m),
                  seriesOf(cycles, [](const auto& c) { return c.estimate_error_m; }), kGreen}};
  plot.y_to = topOf(plot.series, 0.1);
  return plot;
}

Plot speedPlot(const FlightView& view)
{
  const std::vector<CycleSummary>& cycles = view.log.cycles();
  Plot plot;
  plot.style.title = "Speed";
  plot.style.y_label = "speed [m/s]";
  plot.series = {{"flown", seriesOf(cycles, [](const auto& c) { return c.speed_mps; }), kBlue},
                 {"commanded",
                  seriesOf(cycles, [](const auto& c) { return c.commanded_speed_mps; }), kOrange}};
  if (view.info.max_speed_mps > 0.0)
    plot.levels = {{"limit per axis", view.info.max_speed_mps, kLimit}};
  plot.y_to = std::max(topOf(plot.series, 0.5), roundedTop(view.info.max_speed_mps, 0.5));
  return plot;
}

Plot clearancePlot(const FlightView& view)
{
  Plot plot;
  plot.style.title = "Clearance";
  plot.style.y_label = "distance [m]";
  plot.series = {{"centre to the nearest known obstacle",
                  seriesOf(view.log.cycles(), [](const auto& c) { return c.clearance_m; }), kBlue}};
  plot.levels = {
      {"hard " + fixedNumber(view.info.hard_clearance_m, 2), view.info.hard_clearance_m, kLimit},
      {"wanted " + fixedNumber(view.info.wanted_clearance_m, 2), view.info.wanted_clearance_m,
       kWish}};
  plot.y_to = topOf(plot.series, 1.0);
  // Inside an obstacle the distance is negative: show it.
  for (const double value : plot.series.front().values)
    if (value < plot.y_from) plot.y_from = value;
  return plot;
}

}  // namespace

Plot altitudePlot(const FlightView& view)
{
  const std::vector<CycleSummary>& cycles = view.log.cycles();
  Plot plot;
  plot.style.title = "Altitude";
  plot.style.y_label = "z [m]";
  plot.style.x_label = "log time t [s]";
  plot.series = {
      {"flown", seriesOf(cycles, [](const auto& c) { return c.p_L.z(); }), kBlue},
      {"R", seriesOf(cycles, [](const auto& c) { return c.reference_z; }), {{40, 40, 40}, 1}},
      {"refined R",
       seriesOf(cycles, [](const auto& c) { return c.refined_L.z(); }),
       {{214, 20, 120}, 1}}};
  double lo = kNone, hi = kNone;
  for (const Series& series : plot.series)
    for (const double value : series.values) lo = std::fmin(lo, value), hi = std::fmax(hi, value);
  if (!std::isfinite(lo)) lo = 0.0, hi = 1.0;
  const double margin = 0.15 * std::max(hi - lo, 1.0);
  plot.y_from = lo - margin;
  plot.y_to = hi + margin;
  return plot;
}
Canvas drawTracking(const FlightView& view)
{
  constexpr int kWidth = 1500, kHeight = 1100, kLeft = 84, kRight = 24, kTop = 96, kBottom = 62;
  constexpr int kRows = 4, kRowGap = 48;
  constexpr int kPlotHeight = (kHeight - kTop - kBottom - (kRows - 1) * kRowGap) / kRows;
  Canvas canvas(kWidth, kHeight, style::kPanel);
  canvas.text({20.0, 36.0}, "Tracking: " + view.info.title, {22.0, true}, style::kInk);
  std::array<Plot, kRows> plots = {errorPlot(view), speedPlot(view), clearancePlot(view),
                                   altitudePlot(view)};
  const std::vector<double> times =
      seriesOf(view.log.cycles(), [](const CycleSummary& c) { return c.t; });
  for (int i = 0; i < kRows; ++i)
  {
    Plot& plot = plots[static_cast<std::size_t>(i)];
    plot.style.font_size = kFontSize;
    plot.style.x_tick_labels = i == kRows - 1;
    drawPlot(canvas,
             {kLeft, kTop + i * (kPlotHeight + kRowGap), kWidth - kLeft - kRight, kPlotHeight},
             times, plot);
  }
  return canvas;
}

}  // namespace slalom::report::detail
