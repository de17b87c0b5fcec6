// SPDX-License-Identifier: BSD-3-Clause
#include "Text.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <opencv2/imgproc.hpp>
#include <tuple>

namespace slalom::report::detail
{
namespace
{
constexpr int kOversampling = 4;
constexpr int kFace = cv::FONT_HERSHEY_SIMPLEX;
constexpr double kCapitalShare = 0.72;       // of the line height
constexpr double kCapitalAtScaleOne = 21.0;  // [px] of the face
constexpr int kPad = 2;                      // [px] room for strokes left of the pen

double scaleOf(Font font)
{
  return kOversampling * kCapitalShare * font.size / kCapitalAtScaleOne;
}
int strokeOf(Font font)
{
  const double share = font.bold ? 0.135 : 0.09;
  return std::max(1, static_cast<int>(std::lround(kOversampling * share * font.size)));
}

struct Glyph
{
  cv::Mat mask;
  int advance;  ///< in oversampled pixels
};

/// A glyph whose pen starts `phase` quarter pixels into its first pixel.
Glyph drawGlyph(char c, Font font, int phase)
{
  const std::string text(1, c);
  int baseline = 0;
  const double scale = scaleOf(font);
  const int advance = cv::getTextSize(text, kFace, scale, 0, &baseline).width;
  const int width = kOversampling * (advance / kOversampling + 2 * kPad + 2);
  const int height = kOversampling * static_cast<int>(std::ceil(1.35 * font.size));
  cv::Mat large(height, width, CV_8U, cv::Scalar(0));
  cv::putText(large, text, {kOversampling * kPad + phase, kOversampling * textAscent(font)}, kFace,
              scale, cv::Scalar(255), strokeOf(font), cv::LINE_AA);
  Glyph glyph{{}, advance};
  cv::resize(large, glyph.mask, {width / kOversampling, height / kOversampling}, 0, 0,
             cv::INTER_AREA);
  return glyph;
}

/// The same letters come again and again; per thread, so that nothing is shared.
const Glyph& glyphOf(char c, Font font, int phase)
{
  thread_local std::map<std::tuple<char, double, bool, int>, Glyph> cache;
  const auto key = std::make_tuple(c, font.size, font.bold, phase);
  const auto found = cache.find(key);
  return found != cache.end() ? found->second
                              : cache.emplace(key, drawGlyph(c, font, phase)).first->second;
}

char printable(char c)
{
  return c >= ' ' && c <= '~' ? c : '?';
}

int widthOversampled(std::string_view text, Font font)
{
  int width = 0;
  for (const char c : text) width += glyphOf(printable(c), font, 0).advance;
  return width;
}
}  // namespace

int textAscent(Font font)
{
  return static_cast<int>(std::ceil(0.98 * font.size));
}

double textWidth(std::string_view text, Font font)
{
  return static_cast<double>(widthOversampled(text, font)) / kOversampling;
}

cv::Mat textMask(std::string_view text, Font font)
{
  const int width = widthOversampled(text, font) / kOversampling + 2 * kPad + 2;
  cv::Mat mask(static_cast<int>(std::ceil(1.35 * font.size)), width, CV_8U, cv::Scalar(0));
  int pen = 0;
  for (const char c : text)
  {
    const Glyph& glyph = glyphOf(printable(c), font, pen % kOversampling);
    const cv::Rect place =
        cv::Rect({pen / kOversampling, 0}, glyph.mask.size()) & cv::Rect({0, 0}, mask.size());
    cv::Mat target = mask(place);
    cv::max(target, glyph.mask(cv::Rect({0, 0}, place.size())), target);
    pen += glyph.advance;
  }
  return mask;
}

namespace
{
/// How many characters of `text` fit, broken at a space when there is one.
std::size_t fittingPrefix(std::string_view text, Font font, double width)
{
  std::size_t fit = 0;
  double used = 0.0;
  while (fit < text.size() && (used += textWidth(text.substr(fit, 1), font)) <= width) ++fit;
  if (fit == text.size()) return fit;
  const auto space = text.substr(0, fit + 1).rfind(' ');
  return space != std::string_view::npos && space > 0 ? space : std::max<std::size_t>(fit, 1);
}
}  // namespace

std::vector<std::string> wrapText(std::string_view text, Font font, double width, int max_lines)
{
  std::vector<std::string> lines;
  while (!text.empty() && static_cast<int>(lines.size()) < max_lines)
  {
    const std::size_t fit = fittingPrefix(text, font, width);
    lines.emplace_back(text.substr(0, fit));
    text.remove_prefix(fit);
    while (!text.empty() && text.front() == ' ') text.remove_prefix(1);
  }
  if (text.empty() || lines.empty()) return lines;
  std::string& last = lines.back();
  while (!last.empty() && textWidth(last + "...", font) > width) last.pop_back();
  last += "...";
  return lines;
}

}  // namespace slalom::report::detail
