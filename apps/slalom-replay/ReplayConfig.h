// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "slalom/core/Fields.h"

namespace slalom::replay
{
/// INI section [replay].
struct ReplayConfig
{
  std::string mission;                    ///< waypoint file, relative to the INI file that names it
  std::string plugin = "slalom-tracker";  ///< navigator module
  std::string navigator = "TrackerNavigatorFactory";  ///< class name of its factory
  std::string method = "slalom";                      ///< name of the method, for metrics.json
  double min_realtime_factor =
      0.0;  ///< [1] deadline objective: slower than this exits with 6; 0 = none

  template <class Self, class Visit>
  static void fields(Self& c, Visit&& v)
  {
    using core::Level;
    v("mission", c.mission,
      "waypoint file, relative to the INI file that names it; empty: mapping only");
    v("plugin", c.plugin, "navigator module: a name, or a path to the .so", Level::Expert);
    v("navigator", c.navigator, "class name of the navigator's factory", Level::Expert);
    v("method", c.method, "name of the method in metrics.json", Level::Expert);
    v("min_realtime_factor", c.min_realtime_factor, core::Range{0.0, 1000.0},
      "deadline objective: a slower replay exits with 6; 0 = none", Level::Expert);
  }
};

}  // namespace slalom::replay
