// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "Text.h"

namespace slalom::report::detail
{
using Pixel = Eigen::Vector2d;  ///< x to the right, y down; whole numbers are pixel centres
using PixelPath = std::vector<Pixel>;

struct Colour
{
  std::uint8_t r = 0, g = 0, b = 0;
  [[nodiscard]] cv::Scalar bgr() const { return {double(b), double(g), double(r)}; }
  [[nodiscard]] cv::Vec3b bgrBytes() const { return {b, g, r}; }
};
inline constexpr Colour kBlack{0, 0, 0};
inline constexpr Colour kWhite{255, 255, 255};

/// How a line is drawn.
struct Stroke
{
  Colour colour;
  int width = 1;                      ///< [px]
  std::optional<Colour> casing = {};  ///< border of one pixel on each side
  double dash = 0.0, gap = 0.0;       ///< [px]; 0 = solid
};

enum class Align
{
  Left,
  Centre,
  Right
};

/** An image to draw on, anti-aliased, without a display. Non-finite points are skipped. */
class Canvas
{
 public:
  Canvas(int width, int height, Colour background);

  /// The same pixels, clipped to `area`; coordinates stay those of the whole image.
  [[nodiscard]] Canvas clipped(cv::Rect area) const;

  void line(Pixel a, Pixel b, const Stroke& stroke);
  void path(const PixelPath& points, const Stroke& stroke);
  void outline(const PixelPath& polygon, const Stroke& stroke);
  void fill(const PixelPath& polygon, Colour colour, double opacity = 1.0);
  void rectangle(cv::Rect area, Colour colour, double opacity = 1.0);
  void frame(cv::Rect area, Colour colour);
  void disc(Pixel centre, double radius, Colour colour, double opacity = 1.0);
  void circle(Pixel centre, double radius, const Stroke& stroke);
  void arrow(Pixel from, Pixel to, const Stroke& stroke, double head);
  void hatch(cv::Rect area);  ///< the sign of unknown space
  /// `at` is the end of the baseline that `align` names.
  void text(Pixel at, std::string_view text, Font font, Colour colour, Align align = Align::Left);
  /// Reads upwards; `at` is the middle of its right edge.
  void textUpwards(Pixel at, std::string_view text, Font font, Colour colour);

  [[nodiscard]] cv::Mat& pixels() { return image_; }
  [[nodiscard]] const cv::Mat& pixels() const { return image_; }
  [[nodiscard]] int width() const { return image_.cols; }
  [[nodiscard]] int height() const { return image_.rows; }

 private:
  void solid(const PixelPath& points, Colour colour, int width, bool closed);
  void blend(const cv::Mat& mask, cv::Point top_left, Colour colour);
  [[nodiscard]] std::vector<cv::Point> fixedPoint(const PixelPath& points) const;

  cv::Mat image_;
  cv::Point origin_{0, 0};
};

/// Colour of the diagonal hatch at a pixel of the whole image.
[[nodiscard]] Colour hatchAt(int x, int y);

/// Pieces of the path that a dashed stroke covers.
[[nodiscard]] std::vector<PixelPath> dashes(const PixelPath& points, double dash, double gap);

}  // namespace slalom::report::detail
