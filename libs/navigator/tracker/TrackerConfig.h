// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "slalom/core/Fields.h"
#include "slalom/engine/EngineConfig.h"
#include "slalom/mrpt_io/IniDocument.h"
#include "slalom/mrpt_io/ObservationDecoder.h"

namespace slalom::navigator
{
/// INI section [CAbstractNavigator], which MRPT itself reads leniently.
struct MrptNavigatorConfig
{
  double dist_to_target_for_sending_event = 0.0;
  double alarm_seems_not_approaching_target_timeout = 0.0;  ///< MRPT: 30; the engine knows better
  double dist_check_target_is_blocked = 0.6;
  int hysteresis_check_target_is_blocked = 3;
  bool enable_time_profiler = false;

  template <class Self, class Visit>
  static void fields(Self& c, Visit&& v)
  {
    using core::Range;
    constexpr auto kExpert = core::Level::Expert;
    v("dist_to_target_for_sending_event", c.dist_to_target_for_sending_event, Range{0.0, 1e4},
      "the end event is sent this many metres before the goal; 0: at the goal", kExpert);
    v("alarm_seems_not_approaching_target_timeout", c.alarm_seems_not_approaching_target_timeout,
      Range{0.0, 1e6}, "seconds without progress until NAV_ERROR; 0: never", kExpert);
    v("dist_check_target_is_blocked", c.dist_check_target_is_blocked, Range{0.0, 1e4},
      "no effect: the engine judges blocked goals", kExpert);
    v("hysteresis_check_target_is_blocked", c.hysteresis_check_target_is_blocked, Range{1, 1e6},
      "no effect: the engine judges blocked goals", kExpert);
    v("enable_time_profiler", c.enable_time_profiler, "MRPT's own profiler of the state machine",
      kExpert);
  }
};

/// Everything the plugin reads from the host's configuration.
struct TrackerConfig
{
  engine::EngineConfig engine;
  mrpt_io::InputConfig input;
  MrptNavigatorConfig mrpt;
  std::string effective;  ///< INI text of the above with origins
};

/** Reads and checks the plugin's sections. Sections that the plugin does not know belong to the
 * host, unless their name is within two letters of a known one.
 * @throws mrpt_io::ConfigError naming section, key, value and bound */
[[nodiscard]] TrackerConfig readTrackerConfig(const mrpt_io::IniDocument& document);

}  // namespace slalom::navigator
