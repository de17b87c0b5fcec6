// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>

#include "HostSettings.h"

namespace slalom::app
{
/// INI section [replay].
struct ReplayConfig : PluginConfig
{
  std::string mission;  ///< waypoint file, relative to the INI file that names it
  double min_realtime_factor =
      0.0;  ///< [1] deadline objective: slower than this exits with 6; 0 = none

  template <class Self, class Visit>
  static void fields(Self& c, Visit&& v)
  {
    using core::Level;
    v("mission", c.mission,
      "waypoint file, relative to the INI file that names it; empty: mapping only");
    PluginConfig::fields(c, v);
    v("min_realtime_factor", c.min_realtime_factor, core::Range{0.0, 1000.0},
      "deadline objective: a slower replay exits with 6; 0 = none", Level::Expert);
  }
};

/// All settings of slalom-replay, from files and --set.
struct ReplaySettings : HostSettings
{
  ReplayConfig replay;

  /// [replay] mission, as seen from the INI file that names it; empty: none.
  [[nodiscard]] std::filesystem::path missionFile() const;
};

/** Binds and checks every section that slalom-replay knows. [CAbstractNavigator] is left to the
 * plugin, and the sections of slalom-fly to that program, so that one file serves a flight and its
 * replay. @throws mrpt_io::ConfigError */
[[nodiscard]] ReplaySettings readReplaySettings(const mrpt_io::IniDocument& document);

/// The sections of slalom-replay as Markdown.
[[nodiscard]] std::string describeReplaySettings();

}  // namespace slalom::app
