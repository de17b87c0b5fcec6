// SPDX-License-Identifier: BSD-3-Clause
#include "Canvas.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace slalom::report::detail
{
namespace
{
constexpr int kShift = 4;         // fixed-point bits of OpenCV's drawing functions
constexpr double kFarAway = 1e6;  // [px] keeps fixed-point coordinates inside 32 bits
constexpr Colour kHatchGround{214, 214, 214}, kHatchLine{168, 168, 168};

}  // namespace

Colour hatchAt(int x, int y)
{
  return (x + y) % 8 == 0 ? kHatchLine : kHatchGround;
}

Canvas::Canvas(int width, int height, Colour background)
    : image_(height, width, CV_8UC3, background.bgr())
{
}

Canvas Canvas::clipped(cv::Rect area) const
{
  Canvas part = *this;
  const cv::Rect inside = (area - origin_) & cv::Rect({0, 0}, image_.size());
  part.image_ = image_(inside);
  part.origin_ = inside.tl() + origin_;
  return part;
}

std::vector<cv::Point> Canvas::fixedPoint(const PixelPath& points) const
{
  std::vector<cv::Point> fixed;
  fixed.reserve(points.size());
  const auto convert = [](double value, int origin)
  {
    const double clamped = std::clamp(value - origin, -kFarAway, kFarAway);
    return static_cast<int>(std::lround(clamped * (1 << kShift)));
  };
  for (const Pixel& p : points)
    if (p.allFinite()) fixed.emplace_back(convert(p.x(), origin_.x), convert(p.y(), origin_.y));
  return fixed;
}

void Canvas::solid(const PixelPath& points, Colour colour, int width, bool closed)
{
  const std::vector<cv::Point> fixed = fixedPoint(points);
  if (fixed.size() < 2) return;
  cv::polylines(image_, fixed, closed, colour.bgr(), width, cv::LINE_AA, kShift);
}

void Canvas::line(Pixel a, Pixel b, const Stroke& stroke)
{
  path({a, b}, stroke);
}

void Canvas::path(const PixelPath& points, const Stroke& stroke)
{
  const std::vector<PixelPath> pieces =
      stroke.dash > 0.0 ? dashes(points, stroke.dash, stroke.gap) : std::vector<PixelPath>{points};
  if (stroke.casing)
    for (const PixelPath& piece : pieces) solid(piece, *stroke.casing, stroke.width + 2, false);
  for (const PixelPath& piece : pieces) solid(piece, stroke.colour, stroke.width, false);
}

void Canvas::outline(const PixelPath& polygon, const Stroke& stroke)
{
  if (stroke.casing) solid(polygon, *stroke.casing, stroke.width + 2, true);
  solid(polygon, stroke.colour, stroke.width, true);
}

void Canvas::fill(const PixelPath& polygon, Colour colour, double opacity)
{
  std::vector<cv::Point> fixed = fixedPoint(polygon);
  if (fixed.size() < 3) return;
  if (opacity >= 1.0)
  {
    cv::fillPoly(image_, std::vector<std::vector<cv::Point>>{fixed}, colour.bgr(), cv::LINE_AA,
                 kShift);
    return;
  }
  Eigen::Vector2d lo = polygon.front(), hi = polygon.front();
  for (const Pixel& p : polygon) lo = lo.cwiseMin(p), hi = hi.cwiseMax(p);
  const auto clampPixel = [](double v) { return static_cast<int>(std::clamp(v, -1e5, 1e5)); };
  const cv::Point top_left(clampPixel(lo.x()) - 2, clampPixel(lo.y()) - 2);
  const cv::Point bottom_right(clampPixel(hi.x()) + 3, clampPixel(hi.y()) + 3);
  const cv::Rect box =
      (cv::Rect(top_left, bottom_right) - origin_) & cv::Rect({0, 0}, image_.size());
  if (box.empty()) return;
  cv::Mat mask(box.size(), CV_8U, cv::Scalar(0));
  for (cv::Point& p : fixed) p -= cv::Point(box.x << kShift, box.y << kShift);
  cv::fillPoly(mask, std::vector<std::vector<cv::Point>>{fixed}, cv::Scalar(255.0 * opacity),
               cv::LINE_AA, kShift);
  blend(mask, box.tl() + origin_, colour);
}

void Canvas::rectangle(cv::Rect area, Colour colour, double opacity)
{
  const cv::Rect box = (area - origin_) & cv::Rect({0, 0}, image_.size());
  if (box.empty()) return;
  if (opacity >= 1.0)
    image_(box).setTo(colour.bgr());
  else
    blend(cv::Mat(box.size(), CV_8U, cv::Scalar(255.0 * opacity)), box.tl() + origin_, colour);
}

void Canvas::frame(cv::Rect area, Colour colour)
{
  cv::rectangle(image_, area - origin_, colour.bgr(), 1);
}

void Canvas::disc(Pixel centre, double radius, Colour colour, double opacity)
{
  if (!centre.allFinite() || radius > kFarAway) return;
  PixelPath ring;
  constexpr int kCorners = 40;
  for (int i = 0; i < kCorners; ++i)
  {
    const double angle = 2.0 * CV_PI * i / kCorners;
    ring.push_back(centre + radius * Pixel(std::cos(angle), std::sin(angle)));
  }
  fill(ring, colour, opacity);
}

void Canvas::circle(Pixel centre, double radius, const Stroke& stroke)
{
  PixelPath ring;
  constexpr int kCorners = 48;
  for (int i = 0; i <= kCorners; ++i)
  {
    const double angle = 2.0 * CV_PI * i / kCorners;
    ring.push_back(centre + radius * Pixel(std::cos(angle), std::sin(angle)));
  }
  path(ring, stroke);
}

void Canvas::arrow(Pixel from, Pixel to, const Stroke& stroke, double head)
{
  if (!from.allFinite() || !to.allFinite() || (to - from).norm() < 1.0) return;
  const Pixel along = (to - from).normalized();
  const Pixel across(-along.y(), along.x());
  const double length = std::min(head, 0.6 * (to - from).norm());
  const Pixel neck = to - length * along;
  const auto headOf = [&](double grown)
  {
    return PixelPath{to + 1.5 * grown * along,
                     neck - grown * along + (0.45 * length + grown) * across,
                     neck - grown * along - (0.45 * length + grown) * across};
  };
  if (stroke.casing)
  {
    line(from, neck, {*stroke.casing, stroke.width + 2});
    fill(headOf(1.0), *stroke.casing);
  }
  line(from, neck, {stroke.colour, stroke.width});
  fill(headOf(0.0), stroke.colour);
}

void Canvas::hatch(cv::Rect area)
{
  const cv::Rect box = (area - origin_) & cv::Rect({0, 0}, image_.size());
  for (int y = box.y; y < box.y + box.height; ++y)
    for (int x = box.x; x < box.x + box.width; ++x)
      image_.at<cv::Vec3b>(y, x) = hatchAt(x + origin_.x, y + origin_.y).bgrBytes();
}

void Canvas::blend(const cv::Mat& mask, cv::Point top_left, Colour colour)
{
  const cv::Rect all({0, 0}, image_.size());
  const cv::Rect box = cv::Rect(top_left - origin_, mask.size()) & all;
  if (box.empty()) return;
  const cv::Point skipped = box.tl() - (top_left - origin_);
  const int ink[3] = {colour.b, colour.g, colour.r};
  for (int y = 0; y < box.height; ++y)
  {
    const std::uint8_t* cover = mask.ptr<std::uint8_t>(y + skipped.y) + skipped.x;
    std::uint8_t* out = image_.ptr<std::uint8_t>(box.y + y) + 3 * box.x;
    for (int x = 0; x < box.width; ++x, out += 3)
      for (int c = 0; c < 3; ++c)
        out[c] =
            static_cast<std::uint8_t>((out[c] * (255 - cover[x]) + ink[c] * cover[x] + 127) / 255);
  }
}

void Canvas::text(Pixel at, std::string_view text, Font font, Colour colour, Align align)
{
  const double width = textWidth(text, font);
  const double shift = align == Align::Left ? 0.0 : align == Align::Right ? width : 0.5 * width;
  constexpr int kPad = 2;  // of textMask()
  blend(textMask(text, font),
        {static_cast<int>(std::lround(at.x() - shift)) - kPad,
         static_cast<int>(std::lround(at.y())) - textAscent(font)},
        colour);
}

void Canvas::textUpwards(Pixel at, std::string_view text, Font font, Colour colour)
{
  cv::Mat mask;
  cv::rotate(textMask(text, font), mask, cv::ROTATE_90_COUNTERCLOCKWISE);
  blend(mask,
        {static_cast<int>(std::lround(at.x())) - mask.cols,
         static_cast<int>(std::lround(at.y())) - mask.rows / 2},
        colour);
}

std::vector<PixelPath> dashes(const PixelPath& points, double dash, double gap)
{
  std::vector<PixelPath> pieces;
  bool drawing = true;
  double left = dash;  // until pen goes up or down
  if (!points.empty()) pieces.push_back({points.front()});
  for (std::size_t i = 1; i < points.size(); ++i)
  {
    Pixel from = points[i - 1];
    double rest = (points[i] - from).norm();
    if (!std::isfinite(rest) || rest > kFarAway) continue;
    while (rest >= left)
    {
      from += left / rest * (points[i] - from);
      rest -= left;
      if (drawing) pieces.back().push_back(from);
      drawing = !drawing;
      left = drawing ? dash : gap;
      if (drawing) pieces.push_back({from});
      if (rest <= 0.0) break;
    }
    left -= std::min(rest, left);
    if (drawing) pieces.back().push_back(points[i]);
  }
  return pieces;
}

}  // namespace slalom::report::detail
