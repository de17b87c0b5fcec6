// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>

#include "slalom/core/Fields.h"
#include "slalom/engine/EngineConfig.h"
#include "slalom/mrpt_io/IniDocument.h"
#include "slalom/mrpt_io/ObservationDecoder.h"
#include "slalom/report/ReportConfig.h"

namespace slalom::app
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

/// All settings of slalom-replay, from files and --set.
struct ReplaySettings
{
  mrpt_io::IniDocument document;  ///< what the following was read from
  engine::EngineConfig engine;
  mrpt_io::InputConfig input;
  report::ReportConfig report;
  ReplayConfig replay;
  std::string effective;  ///< INI text of the above with origins

  /// [replay] mission, as seen from the INI file that names it; empty: none.
  [[nodiscard]] std::filesystem::path missionFile() const;
};

/** Binds and checks every section that slalom-replay knows. [CAbstractNavigator] is left to the
 * plugin. @throws mrpt_io::ConfigError */
[[nodiscard]] ReplaySettings readReplaySettings(const mrpt_io::IniDocument& document);

/// The sections of slalom-replay as Markdown.
[[nodiscard]] std::string describeReplaySettings();

}  // namespace slalom::app
