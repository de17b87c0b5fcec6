// SPDX-License-Identifier: BSD-3-Clause
#include "CyclePicture.h"

#include <algorithm>
#include <cmath>

#include "Axes.h"
#include "FieldSlice.h"
#include "Geometry2d.h"
#include "RowFiles.h"
#include "Style.h"

namespace slalom::report::detail
{
namespace
{
/// The vehicle's place; after an estimate that is not finite, the last one that was.
Eigen::Vector3d placeOf(const CycleView& view)
{
  if (view.record.has_state && view.record.state.p_L.allFinite()) return view.record.state.p_L;
  for (auto cycle = view.flown.rbegin(); cycle != view.flown.rend(); ++cycle)
    if (cycle->p_L.allFinite()) return cycle->p_L;
  return Eigen::Vector3d::Zero();
}

PixelPath project(const Axes& axes, const core::Polyline& line)
{
  PixelPath path;
  for (Eigen::Index i = 0; i < line.cols(); ++i)
    path.push_back(axes.toPixel(Eigen::Vector2d(line.col(i).head<2>())));
  return path;
}

void drawLines(Canvas& canvas, const Axes& axes, const std::vector<core::Polyline>& lines,
               const Stroke& stroke)
{
  for (const core::Polyline& line : lines) canvas.path(project(axes, line), stroke);
}

void drawField(Canvas& canvas, const Axes& axes, const CycleView& view)
{
  if (!view.record.field)
  {
    canvas.hatch(axes.area);
    const Pixel middle(axes.area.x + 0.5 * axes.area.width, axes.area.y + 0.25 * axes.area.height);
    canvas.text(middle, "no map yet", {28.0, true}, style::kInk, Align::Centre);
    return;
  }
  const FieldSlice slice =
      sliceField(*view.record.field, placeOf(view).z(), {axes.x0, axes.y0}, {axes.x1, axes.y1});
  paintSlice(canvas, axes, slice, distanceScale(view.record),
             {{view.info.wanted_clearance_m, style::kWantedContour},
              {view.info.hard_clearance_m, style::kHardContour}});
}

void drawPolyhedra(Canvas& canvas, const Axes& axes, const CycleView& view)
{
  const double z = placeOf(view).z();
  std::vector<PixelPath> slices;
  for (const core::HalfSpaces& body : view.record.refinement.polyhedra)
  {
    PixelPath corners;
    for (const Eigen::Vector2d& p :
         horizontalSlice(body, z, {axes.x0 - 1.0, axes.y0 - 1.0}, {axes.x1 + 1.0, axes.y1 + 1.0}))
      corners.push_back(axes.toPixel(p));
    slices.push_back(std::move(corners));
  }
  for (const PixelPath& slice : slices)
    canvas.fill(slice, style::kPolyhedron, style::kPolyhedronOpacity);
  for (const PixelPath& slice : slices) canvas.outline(slice, style::kPolyhedronEdge);
}

void drawTrail(Canvas& canvas, const Axes& axes, const std::vector<CycleSummary>& flown)
{
  PixelPath trail;
  for (const CycleSummary& cycle : flown)
  {
    const Pixel p = axes.toPixel(Eigen::Vector2d(cycle.p_L.head<2>()));
    if (p.allFinite() && (trail.empty() || (p - trail.back()).norm() > 2.0)) trail.push_back(p);
  }
  canvas.path(trail, style::kTrail);
}

void drawHorizon(Canvas& canvas, const Axes& axes, const core::Polyline& horizon)
{
  const PixelPath stages = project(axes, horizon);
  canvas.path(stages, style::kHorizon);
  for (const Pixel& stage : stages)
  {
    canvas.disc(stage, 3.4, *style::kHorizon.casing);
    canvas.disc(stage, 2.4, style::kHorizon.colour);
  }
}

/// Where each mover is, and where it will be in a second.
void drawMovers(Canvas& canvas, const Axes& axes, const core::CycleRecord& record)
{
  for (const core::MovingObstacle& mover : record.movers)
  {
    const Pixel now = axes.toPixel(Eigen::Vector2d(mover.at(record.t).head<2>()));
    const Pixel later = axes.toPixel(Eigen::Vector2d(mover.at(record.t + 1.0).head<2>()));
    canvas.disc(now, mover.radius_m * axes.pixelsPerUnit(), style::kMover, style::kMoverOpacity);
    canvas.arrow(now, later, style::kMoverMotion, 9.0);
  }
}

void drawGoal(Canvas& canvas, const Axes& axes, const CycleView& view)
{
  const core::CycleRecord& record = view.record;
  if (record.reference.cols() == 0) return;
  const Eigen::Vector2d goal = record.reference.rightCols<1>().head<2>();
  const Eigen::Vector2d here = placeOf(view).head<2>();
  const double margin = 20.0 / axes.pixelsPerUnit();
  const Eigen::Vector2d lo(axes.x0 + margin, axes.y0 + margin),
      hi(axes.x1 - margin, axes.y1 - margin);
  const Eigen::Vector2d shown = clampToBox(here, goal, lo, hi);
  const Pixel at = axes.toPixel(shown);
  if ((shown - goal).norm() < 1e-9) return drawPlace(canvas, at, style::kGoal, 9.0);

  // Out of the picture: an arrow on the border that points to it.
  const Pixel along = (axes.toPixel(goal) - axes.toPixel(here)).normalized();
  canvas.arrow(at - 26.0 * along, at + 8.0 * along, {style::kGoal, 4, kWhite}, 15.0);
  const std::string label = "goal " + fixedNumber((goal - here).norm(), 1) + " m";
  const Font font{13.0, true};
  const double width = textWidth(label, font);
  const bool low = at.y() > axes.area.y + 0.5 * axes.area.height;
  const double left = std::clamp(at.x() - 0.5 * width, axes.area.x + 8.0,
                                 axes.area.x + axes.area.width - width - 8.0);
  const double baseline = at.y() + (low ? -34.0 : 44.0);
  canvas.rectangle({static_cast<int>(left) - 4, static_cast<int>(baseline) - 14,
                    static_cast<int>(width) + 9, 20},
                   kWhite, 0.85);
  canvas.text({left, baseline}, label, font, style::kGoal);
}

void drawPlans(Canvas& canvas, const Axes& axes, const CycleView& view)
{
  const core::CycleRecord& record = view.record;
  const core::RefinementRecord& refinement = record.refinement;
  drawPolyhedra(canvas, axes, view);
  drawLines(canvas, axes, refinement.occupied_segments, style::kOccupiedSegment);
  canvas.path(project(axes, record.reference), style::kReference);
  drawTrail(canvas, axes, view.flown);
  canvas.path(project(axes, record.refined), style::kRefined);
  canvas.path(project(axes, record.committed), style::kCommitted);
  drawLines(canvas, axes, refinement.guides, style::kGuide);
  drawLines(canvas, axes, refinement.pushing_paths, style::kPushingPath);
  for (const core::PushArrow& arrow : refinement.directions)
    canvas.arrow(axes.toPixel(Eigen::Vector2d(arrow.from_L.head<2>())),
                 axes.toPixel(Eigen::Vector2d(arrow.to_L.head<2>())), style::kDirection, 8.0);
  drawMovers(canvas, axes, record);
  drawHorizon(canvas, axes, record.horizon);
  if (record.has_state)
    drawVehicle(canvas, axes.toPixel(Eigen::Vector2d(record.state.p_L.head<2>())),
                view.info.vehicle_radius_m * axes.pixelsPerUnit(), record.state.yaw());
  else
    canvas.text({axes.area.x + 0.5 * axes.area.width, axes.area.y + 0.35 * axes.area.height},
                "no estimate yet", {28.0, true}, style::kInk, Align::Centre);
  drawGoal(canvas, axes, view);
}
}  // namespace

double distanceScale(const core::CycleRecord& record)
{
  constexpr double kMostTelling = 3.0;  // [m] beyond this, more distance changes nothing
  return record.field ? std::min(record.field->maxDistance(), kMostTelling) : kMostTelling;
}

void drawPlace(Canvas& canvas, Pixel at, Colour colour, double radius)
{
  canvas.disc(at, radius + 1.5, kWhite);
  canvas.disc(at, radius, colour);
  canvas.disc(at, 0.62 * radius, kWhite);
  canvas.disc(at, 0.34 * radius, colour);
}

void drawVehicle(Canvas& canvas, Pixel at, double radius, double yaw)
{
  const double drawn = std::max(radius, 5.0);
  const Pixel ahead(std::cos(yaw), -std::sin(yaw));
  canvas.disc(at, drawn, style::kVehicle, 0.75);
  canvas.circle(at, drawn, {style::kInk, 2});
  canvas.arrow(at - 0.45 * drawn * ahead, at + (drawn + 7.0) * ahead, {style::kInk, 2, kWhite},
               9.0);
}

Canvas drawCyclePicture(const CycleView& view)
{
  const int height = view.config.picture_size_px, width = height * 7 / 5;
  const double font_size = height / 60.0;
  const double half = view.config.view_half_width_m;
  const int left = static_cast<int>(4.6 * font_size), top = static_cast<int>(2.4 * font_size);
  const int side = height - top - static_cast<int>(3.6 * font_size);
  const Eigen::Vector2d here = placeOf(view).head<2>();
  const Eigen::Vector2d reach = Eigen::Vector2d::Constant(half);
  const Axes axes = Axes::equalScale({left, top, side, side}, here - reach, here + reach);

  Canvas canvas(width, height, style::kPanel);
  drawField(canvas, axes, view);
  Canvas map = canvas.clipped(axes.area);
  drawPlans(map, axes, view);
  drawScaleBar(canvas, axes, {left + 10.0, top + side - 10.0}, font_size);
  AxesStyle look;
  look.title = "Map at altitude z = " + fixedNumber(placeOf(view).z(), 2) + " m, from above";
  look.x_label = "east x [m]";
  look.y_label = "north y [m]";
  look.font_size = font_size;
  drawFrame(canvas, axes, look);
  const int panel = left + side + static_cast<int>(1.4 * font_size);
  drawCyclePanel(canvas, {panel, 0, width - panel - static_cast<int>(font_size), height}, view,
                 font_size);
  return canvas;
}

}  // namespace slalom::report::detail
