// SPDX-License-Identifier: BSD-3-Clause
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
constexpr double kMs = 1e3;

struct Part
{
  const char* title;
  double core::CycleTiming::*time;
  const Distribution& distribution;
  double deadline_s;
};

std::string named(const char* name, std::optional<double> seconds)
{
  return std::string(name) + " " + fixedNumber(seconds.value_or(0.0) * kMs, 2);
}

Plot plotOf(const Part& part, const std::vector<CycleSummary>& cycles, bool last_row)
{
  Plot plot;
  const Distribution& d = part.distribution;
  plot.style.title = part.title;
  plot.style.y_label = "wall time [ms]";
  plot.style.x_label = last_row ? "log time t [s]" : "";
  plot.style.font_size = kFontSize;
  plot.legend_on_own_line = true;
  plot.series = {{"",
                  seriesOf(cycles,
                           [&](const CycleSummary& c)
                           {
                             const double spent = c.timing.*part.time;
                             return spent > 0.0 ? spent * kMs : kNone;
                           }),
                  {{31, 119, 180}, 1},
                  true}};
  double top = d.max.value_or(0.0) * kMs;
  if (d.n > 0)
  {
    plot.levels = {{named("median", d.median), *d.median * kMs, {{20, 140, 60}, 1}},
                   {named("p95", d.p95), *d.p95 * kMs, {{230, 140, 0}, 1}},
                   {named("p99", d.p99), *d.p99 * kMs, {{150, 60, 180}, 1}}};
  }
  if (part.deadline_s > 0.0)
  {
    const double deadline = part.deadline_s * kMs;
    plot.levels.push_back(
        {"deadline " + fixedNumber(deadline, 0), deadline, {{214, 39, 40}, 2, {}, 8.0, 5.0}});
    // A deadline far above everything would press the data onto the axis.
    if (deadline < 3.0 * top) top = std::max(top, deadline);
  }
  plot.y_to = roundedTop(top, 0.1);
  return plot;
}
}  // namespace

Canvas drawTiming(const FlightView& view)
{
  using core::CycleTiming;
  const TimingMetrics& m = view.metrics.timing;
  const std::array<Part, 6> parts = {{
      {"Estimate", &CycleTiming::estimate, m.estimate, 0.0},
      {"Map fusion", &CycleTiming::map, m.map, view.info.map_deadline_s},
      {"Distance transform", &CycleTiming::edt, m.edt, 0.0},
      {"Global planner", &CycleTiming::global, m.global, view.info.global_deadline_s},
      {"Local planner", &CycleTiming::local, m.local, view.info.local_deadline_s},
      {"Whole cycle", &CycleTiming::cycle, m.cycle, 0.0},
  }};
  constexpr int kWidth = 1500, kHeight = 1060, kColumns = 2, kRows = 3;
  constexpr int kLeft = 74, kTop = 128, kColumnGap = 92, kRowGap = 84, kRight = 24, kBottom = 62;
  constexpr int kPlotWidth = (kWidth - kLeft - kRight - (kColumns - 1) * kColumnGap) / kColumns;
  constexpr int kPlotHeight = (kHeight - kTop - kBottom - (kRows - 1) * kRowGap) / kRows;
  Canvas canvas(kWidth, kHeight, style::kPanel);
  canvas.text({20.0, 34.0}, "Wall time of each part of a cycle: " + view.info.title, {22.0, true},
              style::kInk);
  canvas.text({20.0, 62.0},
              "Deadline misses: map " + std::to_string(m.map_misses) + ", global " +
                  std::to_string(m.global_misses) + ", local " + std::to_string(m.local_misses) +
                  " in " + std::to_string(view.metrics.cycles) +
                  " cycles. One dot per cycle; the map's deadline is for map fusion and distance "
                  "transform together.",
              {kFontSize}, style::kFaint);
  const std::vector<CycleSummary>& cycles = view.log.cycles();
  const std::vector<double> times = seriesOf(cycles, [](const CycleSummary& c) { return c.t; });
  for (int i = 0; i < static_cast<int>(parts.size()); ++i)
  {
    const int column = i % kColumns, row = i / kColumns;
    drawPlot(canvas,
             {kLeft + column * (kPlotWidth + kColumnGap), kTop + row * (kPlotHeight + kRowGap),
              kPlotWidth, kPlotHeight},
             times, plotOf(parts[static_cast<std::size_t>(i)], cycles, row == kRows - 1));
  }
  return canvas;
}

}  // namespace slalom::report::detail
