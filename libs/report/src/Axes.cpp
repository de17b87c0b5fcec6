// SPDX-License-Identifier: BSD-3-Clause
#include "Axes.h"

#include <algorithm>
#include <cmath>

#include "RowFiles.h"

namespace slalom::report::detail
{
namespace
{
constexpr Colour kGridLine{226, 226, 226};
constexpr Colour kInk{30, 30, 30};

double niceStep(double at_least)
{
  const double decade = std::pow(10.0, std::floor(std::log10(at_least)));
  for (const double factor : {1.0, 2.0, 5.0})
    if (factor * decade >= at_least * (1.0 - 1e-9)) return factor * decade;
  return 10.0 * decade;
}

int tickCount(int pixels, double per_tick)
{
  return std::max(2, static_cast<int>(pixels / per_tick));
}
Ticks xTicks(const Axes& a, double font_size)
{
  return niceTicks(a.x0, a.x1, tickCount(a.area.width, 4.5 * font_size));
}
Ticks yTicks(const Axes& a, double font_size)
{
  return niceTicks(a.y0, a.y1, tickCount(a.area.height, 1.8 * font_size));
}
}  // namespace

Ticks niceTicks(double lo, double hi, int max_count)
{
  Ticks ticks;
  if (!std::isfinite(lo) || !std::isfinite(hi) || !(hi > lo) || max_count < 1) return ticks;
  ticks.step = niceStep((hi - lo) / max_count);
  const double slack = 1e-9 * (hi - lo);
  const double first = std::ceil((lo - slack) / ticks.step);
  for (double k = first; k * ticks.step <= hi + slack; k += 1.0)
    ticks.values.push_back(k * ticks.step);
  return ticks;
}

std::string Ticks::label(double value) const
{
  const int decimals = std::max(0, static_cast<int>(-std::floor(std::log10(step) + 1e-9)));
  return fixedNumber(value, decimals);
}

Axes Axes::equalScale(cv::Rect area, Eigen::Vector2d lo, Eigen::Vector2d hi)
{
  const Eigen::Vector2d middle = 0.5 * (lo + hi);
  const Eigen::Vector2d size = (hi - lo).cwiseMax(1e-3);
  const double metres_per_pixel = std::max(size.x() / area.width, size.y() / area.height);
  const double half_x = 0.5 * metres_per_pixel * area.width;
  const double half_y = 0.5 * metres_per_pixel * area.height;
  return {area, middle.x() - half_x, middle.x() + half_x, middle.y() - half_y, middle.y() + half_y};
}

Pixel Axes::toPixel(double x, double y) const
{
  return {area.x + (x - x0) / (x1 - x0) * area.width - 0.5,
          area.y + (y1 - y) / (y1 - y0) * area.height - 0.5};
}

void drawGrid(Canvas& canvas, const Axes& a, const AxesStyle& style)
{
  canvas.rectangle(a.area, kWhite);
  Canvas inside = canvas.clipped(a.area);
  for (const double x : xTicks(a, style.font_size).values)
    inside.line(a.toPixel(x, a.y0), a.toPixel(x, a.y1), {kGridLine, 1});
  for (const double y : yTicks(a, style.font_size).values)
    inside.line(a.toPixel(a.x0, y), a.toPixel(a.x1, y), {kGridLine, 1});
}

void drawFrame(Canvas& canvas, const Axes& a, const AxesStyle& style)
{
  const Font font{style.font_size};
  const double left = a.area.x, bottom = a.area.y + a.area.height;
  constexpr double kTick = 5.0;
  canvas.frame(a.area, kInk);
  const Ticks xs = xTicks(a, style.font_size), ys = yTicks(a, style.font_size);
  for (const double value : xs.values)
  {
    const double x = a.toPixel(value, a.y0).x();
    canvas.line({x, bottom}, {x, bottom + kTick}, {kInk, 1});
    if (style.x_tick_labels)
      canvas.text({x, bottom + kTick + 1.1 * style.font_size}, xs.label(value), font, kInk,
                  Align::Centre);
  }
  double widest = 0.0;
  for (const double value : ys.values)
  {
    const double y = a.toPixel(a.x0, value).y();
    canvas.line({left - kTick, y}, {left, y}, {kInk, 1});
    canvas.text({left - kTick - 3, y + 0.36 * style.font_size}, ys.label(value), font, kInk,
                Align::Right);
    widest = std::max(widest, textWidth(ys.label(value), font));
  }
  if (!style.x_label.empty())
    canvas.text({left + 0.5 * a.area.width, bottom + kTick + 2.6 * style.font_size}, style.x_label,
                font, kInk, Align::Centre);
  if (!style.y_label.empty())
    canvas.textUpwards({left - kTick - 6 - widest, a.area.y + 0.5 * a.area.height}, style.y_label,
                       font, kInk);
  if (!style.title.empty())
    canvas.text({left, a.area.y - 0.55 * style.font_size}, style.title,
                {1.1 * style.font_size, true}, kInk);
}

void drawScaleBar(Canvas& canvas, const Axes& axes, Pixel at, double font_size)
{
  const double wanted_px = 0.18 * axes.area.width;
  const double metres = niceStep(wanted_px / axes.pixelsPerUnit() / 2.0);
  const double length = metres * axes.pixelsPerUnit();
  const std::string label = fixedNumber(metres, metres < 1.0 ? 1 : 0) + " m";
  const double box_height = 2.3 * font_size;
  canvas.rectangle({static_cast<int>(at.x()), static_cast<int>(at.y() - box_height),
                    static_cast<int>(length + 2.0 * font_size), static_cast<int>(box_height)},
                   kWhite, 0.85);
  const double x = at.x() + font_size, y = at.y() - 0.55 * font_size;
  for (int half = 0; half < 2; ++half)
    canvas.rectangle({static_cast<int>(x + half * 0.5 * length), static_cast<int>(y - 3),
                      static_cast<int>(0.5 * length), 6},
                     half == 0 ? kInk : Colour{170, 170, 170});
  canvas.text({x + 0.5 * length, y - 0.6 * font_size}, label, {font_size}, kInk, Align::Centre);
}

double roundedTop(double largest, double at_least)
{
  const double top = std::isfinite(largest) ? std::max(largest, at_least) : at_least;
  const double step = niceStep(top / 5.0);
  return step * std::ceil(1.05 * top / step - 1e-9);
}

}  // namespace slalom::report::detail
