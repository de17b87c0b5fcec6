// SPDX-License-Identifier: BSD-3-Clause
#include "RecordSettings.h"

#include "slalom/mrpt_io/ConfigBinder.h"

namespace slalom::app
{
namespace
{
/// The one list of slalom-record's sections.
template <class Settings, class Visit>
void sections(Settings& settings, Visit&& visit)
{
  visit("flight", settings.flight);
  sensorSections(settings.sensors, visit);
  visit("forest", settings.forest);
  visit("vehicle", settings.vehicle);
}
}  // namespace

RecordSettings readRecordSettings(const mrpt_io::IniDocument& document)
{
  RecordSettings settings;
  mrpt_io::ConfigBinder binder(document);
  sections(settings, [&binder](const char* name, auto& section) { binder.bind(name, section); });
  binder.finish();
  settings.effective = binder.effective();
  return settings;
}

std::string describeRecordSettings()
{
  std::string markdown;
  const RecordSettings defaults;
  sections(defaults, [&markdown](const char* name, const auto& section)
           { markdown += mrpt_io::describe(name, section) + "\n"; });
  return markdown;
}

}  // namespace slalom::app
