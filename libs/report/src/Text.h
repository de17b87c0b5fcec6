// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <opencv2/core.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace slalom::report::detail
{
/// Look of a piece of text. `size` is the line height in pixels; capitals are 0.72 of it.
struct Font
{
  double size = 14.0;
  bool bold = false;
};

/// Coverage (0..255) of one line of ASCII text; other characters become '?'. Its baseline lies
/// textAscent() below the top row. OpenCV's strokes, drawn four times too large and averaged down.
[[nodiscard]] cv::Mat textMask(std::string_view text, Font font);
[[nodiscard]] double textWidth(std::string_view text, Font font);  ///< [px]
[[nodiscard]] int textAscent(Font font);                           ///< [px]

/// Lines no wider than `width` pixels, broken at spaces (inside a word only when it is too wide);
/// at most `max_lines`, the last one then ends in "...".
[[nodiscard]] std::vector<std::string> wrapText(std::string_view text, Font font, double width,
                                                int max_lines);

}  // namespace slalom::report::detail
