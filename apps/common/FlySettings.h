// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "HostSettings.h"
#include "slalom/simulation/SimulatedFlight.h"

namespace slalom::app
{
/// INI section [fly].
struct FlyConfig : PluginConfig
{
  double time_limit_s = 300.0;       ///< [s] simulated; then TIMEOUT
  double blocked_s = 2.0;            ///< [s] GOAL_BLOCKED for so long ends the flight
  double settle_s = 1.0;             ///< [s] flown on after the end, to see it come to rest
  bool stop_at_contact = true;       ///< false: flies on through what it hit
  double min_realtime_factor = 0.0;  ///< [1] slower than this exits with 6; 0 = none

  template <class Self, class Visit>
  static void fields(Self& c, Visit&& v)
  {
    using core::Level;
    using core::Range;
    v("time_limit_s", c.time_limit_s, Range{0.1, 1e5}, "simulated time after which it is TIMEOUT");
    v("blocked_s", c.blocked_s, Range{0.0, 600.0}, "GOAL_BLOCKED for so long ends the flight");
    v("settle_s", c.settle_s, Range{0.0, 60.0},
      "flown on after the end, so that the truth sees the vehicle come to rest");
    v("stop_at_contact", c.stop_at_contact,
      "a contact ends the flight; false: it flies on through what it hit", Level::Expert);
    PluginConfig::fields(c, v);
    v("min_realtime_factor", c.min_realtime_factor, Range{0.0, 1000.0},
      "deadline objective: a slower simulation exits with 6; 0 = none", Level::Expert);
  }
};

/// All settings of slalom-fly, from files and --set.
struct FlySettings : HostSettings
{
  FlyConfig fly;
  simulation::AirframeConfig airframe;
  simulation::SensorSuite sensors;
};

/** Binds and checks every section that slalom-fly knows; [replay] is left to slalom-replay. Without
 * [input] datum the GPS's is taken. @throws mrpt_io::ConfigError */
[[nodiscard]] FlySettings readFlySettings(mrpt_io::IniDocument document);

/// The sections that only slalom-fly has, as Markdown.
[[nodiscard]] std::string describeFlySettings();

}  // namespace slalom::app
