// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <cmath>

#include "ColourRamp.h"
#include "CyclePicture.h"
#include "FieldSlice.h"
#include "RowFiles.h"
#include "Style.h"

namespace slalom::report::detail
{
namespace
{
using style::kInk;

std::string metres(double value, int decimals = 2)
{
  return std::isfinite(value) ? fixedNumber(value, decimals) + " m" : "-";
}

std::string paddedIndex(std::uint64_t index)
{
  const std::string digits = std::to_string(index);
  return std::string(digits.size() < 6 ? 6 - digits.size() : 0, '0') + digits;
}

struct Line
{
  std::string name, value;
  Colour colour = kInk;
};

Line clearanceLine(const CycleView& view)
{
  const double clearance = view.flown.empty() ? kNone : view.flown.back().clearance_m;
  const Colour colour = clearance < view.info.hard_clearance_m     ? style::kBad
                        : clearance < view.info.wanted_clearance_m ? style::kWarn
                                                                   : style::kInk;
  return {"clearance", metres(clearance), colour};
}

std::string triple(const Eigen::Vector3d& v)
{
  return fixedNumber(v.x(), 2) + "  " + fixedNumber(v.y(), 2) + "  " + fixedNumber(v.z(), 2);
}

std::string refinementText(const core::RefinementRecord& r)
{
  if (r.outcome.empty()) return "-";
  return r.outcome + (r.ran ? "" : " (earlier cycle)");
}

std::string certificateText(const core::RefinementRecord& r)
{
  if (r.outcome.empty()) return "-";
  return r.certified ? "radius + " + metres(r.certificate_margin_m) : "none";
}

std::string solverText(const core::SolveReport& report)
{
  if (report.termination == core::Termination::NotRun) return "-";
  return std::string(core::toString(report.termination)) + ", " +
         std::to_string(report.iterations) + " iterations";
}

std::vector<Line> numbers(const CycleView& view)
{
  const core::CycleRecord& r = view.record;
  const bool mission = r.reference.cols() > 0 && !view.flown.empty();
  const double error = mission ? view.flown.back().vs_reference_m : kNone;
  const double behind = view.flown.empty() ? kNone : view.flown.back().vs_setpoint_m;
  return {clearanceLine(view),
          {"hard, wanted", fixedNumber(view.info.hard_clearance_m, 2) + ", " +
                               metres(view.info.wanted_clearance_m)},
          {"command v, wz", triple(r.command.v_W) + "  " + fixedNumber(r.command.yaw_rate, 2)},
          {"velocity vx vy vz", r.has_state ? triple(r.state.v_W) + " m/s" : "-"},
          {"error to R", metres(error)},
          {"error to setpoint", metres(behind)},
          {"to the goal", mission ? metres(r.distance_to_goal_m, 1) : "-"},
          {"refinement", refinementText(r.refinement)},
          {"why", r.refinement.reason.empty() ? "-" : r.refinement.reason},
          {"certificate", certificateText(r.refinement)},
          {"J solver", solverText(r.refinement.solve)},
          {"NMPC solver", solverText(r.nmpc)},
          {"output gate", r.gate.intervention.empty() ? "passed" : r.gate.intervention},
          {"map no., R no.",
           std::to_string(r.map_sequence) + ", " + std::to_string(r.reference_sequence)}};
}

Colour statusColour(const core::CycleRecord& record)
{
  constexpr std::array<std::string_view, 4> kTrouble = {"ERROR", "COLLISION", "LOST", "TIMEOUT"};
  for (const std::string_view word : kTrouble)
    if (record.status.find(word) != std::string::npos) return style::kBad;
  if (fallbackKind(record.fallback) != FallbackKind::None || !record.gate.intervention.empty() ||
      record.status.find("BLOCKED") != std::string::npos)
    return style::kWarn;
  return style::kGood;
}

/// Clock, status and reason; returns the y below them.
double drawWords(Canvas& canvas, cv::Rect area, const CycleView& view, double size)
{
  const core::CycleRecord& record = view.record;
  const double x = area.x, width = area.width;
  double y = area.y + 2.0 * size;
  const Font title{1.0 * size, false};
  for (const std::string& line : wrapText(view.info.title, title, width, 1))
    canvas.text({x, y}, line, title, style::kFaint);
  y += 2.0 * size;
  canvas.text({x, y}, "t = " + fixedNumber(record.t, 2) + " s", {1.6 * size, true}, kInk);
  canvas.text({x + width, y}, "cycle " + paddedIndex(record.index), {1.15 * size}, kInk,
              Align::Right);

  y += 0.8 * size;
  const int badge = static_cast<int>(1.9 * size);
  canvas.rectangle({area.x, static_cast<int>(y), area.width, badge}, statusColour(record));
  const bool fell_back = fallbackKind(record.fallback) != FallbackKind::None;
  const std::string status = record.status + (fell_back ? "  fallback: " + record.fallback : "");
  canvas.text({x + 0.5 * width, y + 1.35 * size},
              status.empty() ? std::string("(no status)") : status, {1.1 * size, true}, kWhite,
              Align::Centre);
  y += badge + 1.5 * size;

  constexpr int kReasonLines = 2;
  const std::string reason = record.reason.empty() ? "no reason given" : record.reason;
  for (const std::string& line : wrapText(reason, {size}, width, kReasonLines))
  {
    canvas.text({x, y}, line, {size}, kInk);
    y += 1.35 * size;
  }
  return y;
}

void drawDot(Canvas& canvas, cv::Rect box)
{
  const double y = box.y + 0.5 * box.height;
  canvas.line({double(box.x), y}, {double(box.x + box.width), y}, style::kHorizon);
  for (const double share : {0.2, 0.5, 0.8})
  {
    canvas.disc({box.x + share * box.width, y}, 3.4, *style::kHorizon.casing);
    canvas.disc({box.x + share * box.width, y}, 2.4, style::kHorizon.colour);
  }
}

Pixel middleOf(cv::Rect box)
{
  return {box.x + 0.5 * box.width, box.y + 0.5 * box.height};
}

std::vector<LegendEntry> mapLegend()
{
  return {{"obstacle (occupied)", [](Canvas& c, cv::Rect box) { c.rectangle(box, kBlack); }},
          {"unknown space", [](Canvas& c, cv::Rect box) { c.hatch(box); }},
          {"outside the map window",
           [](Canvas& c, cv::Rect box) { c.rectangle(box, kOutsideColour); }}};
}
}  // namespace

std::vector<LegendEntry> cycleLegend()
{
  std::vector<LegendEntry> entries = mapLegend();
  const auto onColour = [](Stroke stroke)
  {
    return [stroke](Canvas& c, cv::Rect box)
    {
      c.rectangle(box, ColourRamp::distance().at(0.35));
      const double y = box.y + 0.5 * box.height;
      c.line({double(box.x), y}, {double(box.x + box.width), y}, stroke);
    };
  };
  entries.push_back({"contour: hard clearance", onColour(style::kHardContour)});
  entries.push_back({"contour: wanted clearance", onColour(style::kWantedContour)});
  entries.push_back(lineEntry("reference R", style::kReference));
  entries.push_back(lineEntry("occupied segment of R", style::kOccupiedSegment));
  entries.push_back({"convex polyhedra (cut)", [](Canvas& c, cv::Rect box)
                     {
                       c.rectangle(box, style::kPolyhedron, style::kPolyhedronOpacity);
                       c.frame(box, style::kPolyhedron);
                     }});
  entries.push_back({"moving obstacle, and in 1 s", [](Canvas& c, cv::Rect box)
                     {
                       c.disc(middleOf(box), 0.45 * box.height, style::kMover,
                              style::kMoverOpacity);
                       c.arrow(middleOf(box), Pixel(double(box.x + box.width), middleOf(box).y()),
                               style::kMoverMotion, 7.0);
                     }});
  entries.push_back(lineEntry("searched guide", style::kGuide));
  entries.push_back(lineEntry("pushing path S*", style::kPushingPath));
  entries.push_back(
      {"pushing direction", [](Canvas& c, cv::Rect box)
       {
         const double y = box.y + 0.5 * box.height;
         c.arrow({double(box.x), y}, {double(box.x + box.width), y}, style::kDirection, 9.0);
       }});
  entries.push_back(lineEntry("refined R, proved clear of all seen", style::kRefined));
  entries.push_back(lineEntry("... in known free space, to a stop", style::kCommitted));
  entries.push_back({"NMPC horizon, stages", drawDot});
  entries.push_back(lineEntry("flown", style::kTrail));
  entries.push_back({"vehicle, its radius and heading", [](Canvas& c, cv::Rect box)
                     { drawVehicle(c, middleOf(box) - Pixel(3.0, 0.0), 0.4 * box.height, 0.0); }});
  entries.push_back({"goal", [](Canvas& c, cv::Rect box)
                     { drawPlace(c, middleOf(box), style::kGoal, 0.5 * box.height); }});
  return entries;
}

void drawCyclePanel(Canvas& canvas, cv::Rect area, const CycleView& view, double size)
{
  double y = drawWords(canvas, area, view, size) + 0.4 * size;
  const double small = 0.9 * size;
  for (const Line& line : numbers(view))
  {
    canvas.text({double(area.x), y}, line.name, {small}, style::kFaint);
    canvas.text({area.x + 10.0 * size, y}, line.value, {small}, line.colour);
    y += 1.4 * size;
  }

  const std::vector<LegendEntry> legend = cycleLegend();
  const double legend_top = area.height - 1.5 * small * double(legend.size()) - 0.8 * size;
  const cv::Rect bar(area.x, static_cast<int>(legend_top - 3.2 * size), area.width,
                     static_cast<int>(0.9 * size));
  drawColourBar(canvas, bar, ColourRamp::distance(), 0.0, distanceScale(view.record),
                "distance to the nearest known obstacle [m]", small);
  drawLegend(canvas, {double(area.x), legend_top}, legend, small);
}

}  // namespace slalom::report::detail
