// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "Axes.h"
#include "ColourRamp.h"
#include "CyclePicture.h"
#include "FieldSlice.h"
#include "FlightPictures.h"
#include "Legend.h"
#include "RowFiles.h"
#include "Style.h"

namespace slalom::report::detail
{
namespace
{
constexpr double kFontSize = 15.0;
constexpr double kDetourM = 0.05;  // nearer to R the refined reference is R

struct Extent
{
  Eigen::Vector2d lo = Eigen::Vector2d::Constant(1e300), hi = Eigen::Vector2d::Constant(-1e300);
  void include(const Eigen::Vector3d& p)
  {
    if (!p.allFinite()) return;
    lo = lo.cwiseMin(p.head<2>());
    hi = hi.cwiseMax(p.head<2>());
  }
};

/// Box around everything that is drawn, with a margin; never smaller than 12 m.
Extent extentOf(const FlightLog& log)
{
  Extent extent;
  for (const CycleSummary& cycle : log.cycles()) extent.include(cycle.p_L);
  for (const Eigen::Vector3d& p : log.truthPath()) extent.include(p);
  const core::Polyline& reference = log.reference();
  for (Eigen::Index i = 0; i < reference.cols(); ++i) extent.include(reference.col(i));
  if (extent.lo.x() > extent.hi.x()) extent.include(Eigen::Vector3d::Zero());
  constexpr double kMargin = 3.0, kSmallest = 12.0;
  const Eigen::Vector2d middle = 0.5 * (extent.lo + extent.hi);
  const Eigen::Vector2d half = (0.5 * (extent.hi - extent.lo) + Eigen::Vector2d::Constant(kMargin))
                                   .cwiseMax(0.5 * kSmallest);
  return {middle - half, middle + half};
}

PixelPath project(const Axes& axes, const std::vector<Eigen::Vector3d>& points)
{
  PixelPath path;
  for (const Eigen::Vector3d& p : points)
    path.push_back(axes.toPixel(Eigen::Vector2d(p.head<2>())));
  return path;
}

void drawMap(Canvas& canvas, const Axes& axes, const MapAccumulator& map)
{
  AxesStyle look;
  look.font_size = kFontSize;
  if (map.empty()) return drawGrid(canvas, axes, look);
  canvas.hatch(axes.area);
  const FieldSlice cells = map.cells({axes.x0, axes.y0}, {axes.x1, axes.y1});
  const cv::Mat state =
      stretch(cells.state, cells.origin_L, cells.cell, axes, cv::INTER_NEAREST, 0.0);
  Canvas inside = canvas.clipped(axes.area);
  inside.pixels().setTo(kWhite.bgr(), state == static_cast<int>(CellState::Free));
  inside.pixels().setTo(style::kInk.bgr(), state == static_cast<int>(CellState::Occupied));
}

/// Stretches in which the refined reference left R, broken where a new refinement jumps.
void drawDetours(Canvas& canvas, const Axes& axes, const std::vector<CycleSummary>& cycles)
{
  constexpr double kJumpM = 0.5;
  PixelPath detour;
  Eigen::Vector3d last = Eigen::Vector3d::Zero();
  const auto finishPiece = [&]
  {
    canvas.path(detour, style::kRefinedBand);
    detour.clear();
  };
  for (const CycleSummary& cycle : cycles)
  {
    const bool left_r = cycle.detour_m > kDetourM;
    if (!left_r || (cycle.refined_L - last).norm() > kJumpM) finishPiece();
    last = cycle.refined_L;
    if (left_r) detour.push_back(axes.toPixel(Eigen::Vector2d(cycle.refined_L.head<2>())));
  }
  finishPiece();
}

double fastest(const FlightView& view)
{
  return roundedTop(view.metrics.max_speed_mps.value_or(0.0), 0.5);
}

void drawFlown(Canvas& canvas, const Axes& axes, const FlightView& view)
{
  const std::vector<CycleSummary>& cycles = view.log.cycles();
  PixelPath all;
  for (const CycleSummary& cycle : cycles)
    all.push_back(axes.toPixel(Eigen::Vector2d(cycle.p_L.head<2>())));
  canvas.path(all, {style::kInk, 5});
  for (std::size_t i = 1; i < all.size(); ++i)
    canvas.line(all[i - 1], all[i],
                {ColourRamp::speed().at(cycles[i].speed_mps / fastest(view)), 3});
}

void drawScene(Canvas& canvas, const Axes& axes, const FlightView& view)
{
  drawMap(canvas, axes, view.map);
  Canvas inside = canvas.clipped(axes.area);
  std::vector<Eigen::Vector3d> reference;
  for (Eigen::Index i = 0; i < view.log.reference().cols(); ++i)
    reference.emplace_back(view.log.reference().col(i));
  inside.path(project(axes, reference), style::kReference);
  const std::vector<CycleSummary>& cycles = view.log.cycles();
  drawDetours(inside, axes, cycles);
  drawFlown(inside, axes, view);
  inside.path(project(axes, view.log.truthPath()), style::kTruth);
  const auto start = std::find_if(cycles.begin(), cycles.end(),
                                  [](const CycleSummary& c) { return c.p_L.allFinite(); });
  if (start != cycles.end())
    drawPlace(inside, axes.toPixel(Eigen::Vector2d(start->p_L.head<2>())), style::kStart, 9.0);
  if (!reference.empty())
    drawPlace(inside, axes.toPixel(Eigen::Vector2d(reference.back().head<2>())), style::kGoal, 9.0);
  drawScaleBar(canvas, axes, {axes.area.x + 10.0, double(axes.area.y + axes.area.height) - 10.0},
               kFontSize);
}

std::string withUnit(std::optional<double> value, int decimals, const char* unit)
{
  return value ? fixedNumber(*value, decimals) + " " + unit : std::string("-");
}

std::vector<std::pair<std::string, std::string>> keyNumbers(const FlightView& view)
{
  const FlightMetrics& m = view.metrics;
  const auto goal = view.summary.goal_error_m ? view.summary.goal_error_m : m.goal_error_m;
  return {{"duration", withUnit(m.duration_s, 1, "s")},
          {"flown length", withUnit(m.length_m, 1, "m")},
          {"length of R", withUnit(m.reference_length_m, 1, "m")},
          {"distance to the goal", withUnit(goal, 2, "m")},
          {"least clearance, map", withUnit(m.min_map_clearance_m, 2, "m")},
          {"least clearance, truth", withUnit(view.summary.min_true_clearance_m, 2, "m")},
          {"error to R, mean", withUnit(m.vs_reference_m.mean, 2, "m")},
          {"error to R, largest", withUnit(m.vs_reference_m.max, 2, "m")},
          {"estimate error, mean", withUnit(m.estimate_error_m.mean, 3, "m")},
          {"speed, mean", withUnit(m.mean_speed_mps, 2, "m/s")},
          {"speed, largest", withUnit(m.max_speed_mps, 2, "m/s")},
          {"cycles", std::to_string(m.cycles)},
          {"refinements ok / failed", std::to_string(m.planning.refined_ok) + " / " +
                                          std::to_string(m.planning.refined_failed)},
          {"fallback cycles",
           std::to_string(m.planning.shifted + m.planning.backup + m.planning.brake)}};
}

double drawNumbers(Canvas& canvas, Pixel at, double width, const FlightView& view)
{
  for (const auto& [name, value] : keyNumbers(view))
  {
    at.y() += 1.4 * kFontSize;
    canvas.text(at, name, {kFontSize}, style::kFaint);
    canvas.text(at + Pixel(width, 0.0), value, {kFontSize}, style::kInk, Align::Right);
  }
  return at.y();
}

std::vector<LegendEntry> overviewLegend(const FlightView& view)
{
  const Stroke flown{ColourRamp::speed().at(0.6), 3, style::kInk};
  const bool mission = view.log.reference().cols() > 0;
  std::vector<LegendEntry> entries = {lineEntry("flown path (estimate)", flown)};
  if (mission)
  {
    entries.push_back(lineEntry("reference R", style::kReference));
    entries.push_back(lineEntry("refined R where it left R", style::kRefinedBand));
  }
  if (!view.log.truthPath().empty()) entries.push_back(lineEntry("ground truth", style::kTruth));
  const auto place = [](Colour colour)
  {
    return [colour](Canvas& c, cv::Rect box) {
      drawPlace(c, {box.x + 0.5 * box.width, box.y + 0.5 * box.height}, colour, 0.5 * box.height);
    };
  };
  entries.push_back({"start", place(style::kStart)});
  if (mission) entries.push_back({"goal", place(style::kGoal)});
  if (view.map.empty()) return entries;
  entries.push_back({"obstacle", [](Canvas& c, cv::Rect box) { c.rectangle(box, style::kInk); }});
  entries.push_back({"known free", [](Canvas& c, cv::Rect box)
                     {
                       c.rectangle(box, kWhite);
                       c.frame(box, style::kFaint);
                     }});
  entries.push_back({"never seen", [](Canvas& c, cv::Rect box) { c.hatch(box); }});
  return entries;
}

void drawTitle(Canvas& canvas, const FlightView& view)
{
  const double x = 1.5 * kFontSize, width = canvas.width() - 2.0 * x;
  const Font title{1.5 * kFontSize, true};
  canvas.text({x, 2.1 * kFontSize}, wrapText(view.info.title, title, 0.62 * width, 1).front(),
              title, style::kInk);
  const RunResult& result = view.summary.result;
  canvas.text({x + width, 2.1 * kFontSize}, result.name, title,
              result.success ? style::kGood : style::kBad, Align::Right);
  const std::string line =
      result.message.empty() ? "exit code " + std::to_string(result.code) : result.message;
  for (const std::string& text : wrapText(line, {kFontSize}, width, 1))
    canvas.text({x, 3.8 * kFontSize}, text, {kFontSize}, style::kFaint);
}

/// The dimension that a view from above hides.
void drawAltitude(Canvas& canvas, cv::Rect area, const FlightView& view)
{
  Plot plot = altitudePlot(view);
  plot.style.font_size = 0.9 * kFontSize;
  plot.legend_on_own_line = true;
  drawPlot(canvas, area, seriesOf(view.log.cycles(), [](const CycleSummary& c) { return c.t; }),
           plot);
}

/// Map and panel beside each other, or, for flat flights, below each other.
struct Layout
{
  int width = 0, height = 0;
  cv::Rect map;
  Pixel numbers, bar, legend;
  cv::Rect altitude;
  double panel_width = 330.0;
};

Layout layoutFor(const Extent& extent, std::size_t legend_entries)
{
  constexpr int kLeft = 84, kTop = 86, kBottom = 58, kRight = 24;
  constexpr int kAltitude = 130;  // [px] height of the altitude plot
  const Eigen::Vector2d size = extent.hi - extent.lo;
  const double shape = size.y() / size.x();
  const double legend_height = 1.5 * kFontSize * double(legend_entries);
  const double panel_height =
      14 * 1.4 * kFontSize + 6.5 * kFontSize + legend_height + kAltitude + 76;
  Layout l;
  if (shape < 0.55)
  {
    const int map_width = 1400;
    l.map = {kLeft, kTop, map_width, std::max(260, static_cast<int>(map_width * shape))};
    l.width = kLeft + map_width + kRight;
    const double top = kTop + l.map.height + kBottom + 14.0;
    l.numbers = {double(kLeft), top};
    l.legend = {kLeft + l.panel_width + 100.0, top + 8.0};
    const double column = kLeft + 2.0 * l.panel_width + 140.0;
    l.bar = {column, top + 2.0 * kFontSize};
    l.altitude = {static_cast<int>(column), static_cast<int>(l.bar.y()) + 104,
                  l.width - kRight - static_cast<int>(column), kAltitude};
    l.height = static_cast<int>(top + 14 * 1.4 * kFontSize + 24.0);
    return l;
  }
  const int map_height =
      std::clamp(static_cast<int>(980 * shape), static_cast<int>(panel_height), 980);
  l.map = {kLeft, kTop, std::clamp(static_cast<int>(map_height / shape), 520, 980), map_height};
  const double x = kLeft + l.map.width + 1.6 * kRight;
  l.width = static_cast<int>(x + l.panel_width) + kRight;
  l.height = kTop + map_height + kBottom;
  l.numbers = {x, kTop - 8.0};
  l.bar = {x, kTop + 14 * 1.4 * kFontSize + 2.8 * kFontSize};
  l.legend = {x, l.bar.y() + 3.6 * kFontSize};
  l.altitude = {static_cast<int>(x) + 44, static_cast<int>(l.legend.y() + legend_height) + 56,
                static_cast<int>(l.panel_width) - 44, kAltitude};
  return l;
}
}  // namespace

Canvas drawOverview(const FlightView& view)
{
  const std::vector<LegendEntry> legend = overviewLegend(view);
  const Extent extent = extentOf(view.log);
  const Layout l = layoutFor(extent, legend.size());
  Canvas canvas(l.width, l.height, style::kPanel);
  const Axes axes = Axes::equalScale(l.map, extent.lo, extent.hi);
  drawScene(canvas, axes, view);
  AxesStyle look;
  look.x_label = "east x [m]";
  look.y_label = "north y [m]";
  look.font_size = kFontSize;
  drawFrame(canvas, axes, look);
  drawTitle(canvas, view);
  drawNumbers(canvas, l.numbers, l.panel_width, view);
  drawColourBar(canvas,
                {static_cast<int>(l.bar.x()), static_cast<int>(l.bar.y()),
                 static_cast<int>(l.panel_width), 14},
                ColourRamp::speed(), 0.0, fastest(view), "speed of the flown path [m/s]",
                kFontSize);
  drawLegend(canvas, l.legend, legend, kFontSize);
  drawAltitude(canvas, l.altitude, view);
  return canvas;
}

}  // namespace slalom::report::detail
