// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "slalom/core/Vehicle.h"
#include "slalom/mrpt_io/IniDocument.h"
#include "slalom/simulation/FlightRecorder.h"
#include "slalom/simulation/Forest.h"
#include "slalom/simulation/ScriptedFlight.h"

namespace slalom::app
{
/// The sections of the sensors on board.
template <class Suite, class Visit>
void sensorSections(Suite& suite, Visit&& visit)
{
  visit("record", suite.record);
  visit("lidar", suite.lidar);
  visit("imu", suite.imu);
  visit("gps", suite.gps);
  visit("velocity", suite.velocity);
}

/// All settings of slalom-record.
struct RecordSettings
{
  simulation::FlightConfig flight;
  simulation::SensorSuite sensors;
  simulation::ForestConfig forest;
  core::Vehicle vehicle;
  std::string effective;  ///< INI text of the above with origins
};

/// Binds and checks every section that slalom-record knows. @throws mrpt_io::ConfigError
[[nodiscard]] RecordSettings readRecordSettings(const mrpt_io::IniDocument& document);

/// The sections of slalom-record as Markdown.
[[nodiscard]] std::string describeRecordSettings();

}  // namespace slalom::app
