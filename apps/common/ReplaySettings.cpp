// SPDX-License-Identifier: BSD-3-Clause
#include "ReplaySettings.h"

#include "slalom/mrpt_io/ConfigBinder.h"

namespace slalom::app
{
namespace
{
/// The one list of sections that slalom-replay has besides the engine's.
template <class Settings, class Visit>
void sections(Settings& settings, Visit&& visit)
{
  visit("input", settings.input);
  visit("report", settings.report);
  visit("replay", settings.replay);
}
}  // namespace

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
  settings.document = document;
  mrpt_io::ConfigBinder binder(document);
  engine::bind(binder, settings.engine);
  sections(settings, [&binder](const char* name, auto& section) { binder.bind(name, section); });
  binder.ignore("CAbstractNavigator");
  binder.finish();
  engine::check(settings.engine);
  settings.effective = binder.effective();
  return settings;
}

std::string describeReplaySettings()
{
  std::string markdown = engine::describeEngineConfig();
  const ReplaySettings defaults;
  sections(defaults, [&markdown](const char* name, const auto& section)
           { markdown += mrpt_io::describe(name, section) + "\n"; });
  return markdown;
}

}  // namespace slalom::app
