// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "slalom/core/Fields.h"

namespace slalom::report
{
/// INI section [report].
struct ReportConfig
{
  double picture_interval_s = 2.0;  ///< [s] log time between cycle pictures; 0 = none
  int picture_size_px = 900;        ///< [px] height of a cycle picture; its width is 1.4 times that
  double view_half_width_m = 8.0;   ///< [m] a cycle picture shows this far in each direction

  template <class Self, class Visit>
  static void fields(Self& c, Visit&& v)
  {
    using core::Level;
    using core::Range;
    v("picture_interval_s", c.picture_interval_s, Range{0.0, 3600.0},
      "log time between pictures of a cycle, 0 = none");
    v("picture_size_px", c.picture_size_px, Range{600, 2400}, "height of those pictures",
      Level::Expert);
    v("view_half_width_m", c.view_half_width_m, Range{2.0, 50.0},
      "how far those pictures show to each side of the vehicle");
  }
};

}  // namespace slalom::report
