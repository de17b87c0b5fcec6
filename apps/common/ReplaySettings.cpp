// SPDX-License-Identifier: BSD-3-Clause
#include "ReplaySettings.h"

namespace slalom::app
{
std::filesystem::path ReplaySettings::missionFile() const
{
  const std::filesystem::path named = replay.mission;
  if (named.empty() || named.is_absolute()) return named;
  const auto* value = document.find("replay", "mission");
  const std::string origin = value ? value->origin : "";
  return std::filesystem::path(origin.substr(0, origin.rfind(':'))).parent_path() / named;
}

ReplaySettings readReplaySettings(const mrpt_io::IniDocument& document)
{
  ReplaySettings settings;
  bindHost(
      document, settings,
      [&settings](mrpt_io::ConfigBinder& binder)
      {
        binder.bind("replay", settings.replay);
        for (const char* section : {"fly", "airframe", "record", "lidar", "imu", "gps", "velocity"})
          binder.ignore(section);
      });
  return settings;
}

std::string describeReplaySettings()
{
  const ReplaySettings defaults;
  return engine::describeEngineConfig() + mrpt_io::describe("input", defaults.input) + "\n" +
         mrpt_io::describe("report", defaults.report) + "\n" +
         mrpt_io::describe("replay", defaults.replay) + "\n";
}

}  // namespace slalom::app
