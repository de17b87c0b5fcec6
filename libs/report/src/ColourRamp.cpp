// SPDX-License-Identifier: BSD-3-Clause
#include "ColourRamp.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "Axes.h"

namespace slalom::report::detail
{
namespace
{
constexpr std::array<std::pair<double, Colour>, 6> kDistanceAnchors = {{
    {0.00, {22, 38, 92}},
    {0.20, {33, 84, 148}},
    {0.40, {49, 135, 178}},
    {0.60, {102, 182, 194}},
    {0.80, {176, 221, 212}},
    {1.00, {246, 250, 240}},
}};

std::uint8_t mix(std::uint8_t a, std::uint8_t b, double share)
{
  return static_cast<std::uint8_t>(std::lround(a + share * (b - a)));
}
}  // namespace

const ColourRamp& ColourRamp::distance()
{
  static const ColourRamp kRamp = []
  {
    ColourRamp ramp;
    for (int i = 0; i < 256; ++i)
    {
      const double u = i / 255.0;
      std::size_t k = 1;
      while (k + 1 < kDistanceAnchors.size() && u > kDistanceAnchors[k].first) ++k;
      const auto& [u0, a] = kDistanceAnchors[k - 1];
      const auto& [u1, b] = kDistanceAnchors[k];
      const double share = (u - u0) / (u1 - u0);
      ramp.colours_[static_cast<std::size_t>(i)] = {mix(a.r, b.r, share), mix(a.g, b.g, share),
                                                    mix(a.b, b.b, share)};
    }
    return ramp;
  }();
  return kRamp;
}

const ColourRamp& ColourRamp::speed()
{
  static const ColourRamp kRamp = []
  {
    cv::Mat steps(256, 1, CV_8U), coloured;
    for (int i = 0; i < 256; ++i) steps.at<std::uint8_t>(i) = static_cast<std::uint8_t>(i);
    cv::applyColorMap(steps, coloured, cv::COLORMAP_VIRIDIS);
    ColourRamp ramp;
    for (int i = 0; i < 256; ++i)
    {
      const cv::Vec3b& bgr = coloured.at<cv::Vec3b>(i);
      ramp.colours_[static_cast<std::size_t>(i)] = {bgr[2], bgr[1], bgr[0]};
    }
    return ramp;
  }();
  return kRamp;
}

Colour ColourRamp::at(double share) const
{
  if (!(share > 0.0)) return colours_.front();  // also NaN
  return colours_[static_cast<std::size_t>(std::lround(255.0 * std::min(share, 1.0)))];
}

cv::Mat ColourRamp::lookupTable() const
{
  cv::Mat table(256, 1, CV_8UC3);
  for (int i = 0; i < 256; ++i)
    table.at<cv::Vec3b>(i) = colours_[static_cast<std::size_t>(i)].bgrBytes();
  return table;
}

void drawColourBar(Canvas& canvas, cv::Rect area, const ColourRamp& ramp, double lo, double hi,
                   std::string_view label, double font_size)
{
  const Font font{font_size};
  canvas.text({double(area.x), area.y - 0.45 * font_size}, label, font, kBlack);
  for (int x = 0; x < area.width; ++x)
    canvas.rectangle({area.x + x, area.y, 1, area.height}, ramp.at(x / double(area.width - 1)));
  canvas.frame(area, kBlack);
  const Ticks ticks = niceTicks(lo, hi, 6);
  for (const double value : ticks.values)
  {
    const double x = area.x + (value - lo) / (hi - lo) * (area.width - 1);
    const double bottom = area.y + area.height;
    canvas.line({x, bottom}, {x, bottom + 4}, {kBlack, 1});
    canvas.text({x, bottom + 5 + font_size}, ticks.label(value), font, kBlack, Align::Centre);
  }
}

}  // namespace slalom::report::detail
