// SPDX-License-Identifier: BSD-3-Clause
#include "Legend.h"

#include <utility>

namespace slalom::report::detail
{
namespace
{
constexpr Colour kInk{30, 30, 30};

void drawEntry(Canvas& canvas, const LegendEntry& entry, Pixel baseline, double font_size)
{
  const int width = static_cast<int>(2.2 * font_size), height = static_cast<int>(font_size);
  entry.draw(canvas, {static_cast<int>(baseline.x()),
                      static_cast<int>(baseline.y() - 0.86 * font_size), width, height});
  canvas.text({baseline.x() + width + 0.8 * font_size, baseline.y()}, entry.label, {font_size},
              kInk);
}
double entryWidth(const LegendEntry& entry, double font_size)
{
  return 3.0 * font_size + textWidth(entry.label, {font_size});
}
}  // namespace

LegendEntry lineEntry(std::string label, Stroke stroke)
{
  return {std::move(label), [stroke](Canvas& canvas, cv::Rect box)
          {
            const double y = box.y + 0.5 * box.height;
            canvas.line({double(box.x), y}, {double(box.x + box.width), y}, stroke);
          }};
}

double drawLegend(Canvas& canvas, Pixel top_left, const std::vector<LegendEntry>& entries,
                  double font_size)
{
  const double pitch = 1.5 * font_size;
  for (std::size_t i = 0; i < entries.size(); ++i)
    drawEntry(canvas, entries[i], top_left + Pixel(0.0, font_size + pitch * double(i)), font_size);
  return pitch * double(entries.size());
}

void drawLegendRow(Canvas& canvas, Pixel right_baseline, const std::vector<LegendEntry>& entries,
                   double font_size)
{
  const double space = 1.4 * font_size;
  double x = right_baseline.x();
  for (auto entry = entries.rbegin(); entry != entries.rend(); ++entry)
  {
    x -= entryWidth(*entry, font_size);
    drawEntry(canvas, *entry, {x, right_baseline.y()}, font_size);
    x -= space;
  }
}

}  // namespace slalom::report::detail
