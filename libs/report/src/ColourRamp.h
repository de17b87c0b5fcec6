// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <string_view>

#include "Canvas.h"

namespace slalom::report::detail
{
/// Colours for numbers, 256 steps from low to high; lightness rises all the way, so it survives
/// grey printing and colour blindness.
class ColourRamp
{
 public:
  /// Distance to obstacles: deep blue (near) over teal to nearly white (far).
  [[nodiscard]] static const ColourRamp& distance();
  /// Speed: OpenCV's viridis.
  [[nodiscard]] static const ColourRamp& speed();

  [[nodiscard]] Colour at(double share) const;  ///< share of the range, clamped to 0..1
  [[nodiscard]] cv::Mat lookupTable() const;    ///< 256x1, BGR, for cv::applyColorMap

 private:
  std::array<Colour, 256> colours_{};
};

/// A labelled bar with ticks below it; `area` is the bar itself.
void drawColourBar(Canvas& canvas, cv::Rect area, const ColourRamp& ramp, double lo, double hi,
                   std::string_view label, double font_size);

}  // namespace slalom::report::detail
