// SPDX-License-Identifier: BSD-3-Clause
#include "Config.h"

#include <sstream>

#include "FlySettings.h"
#include "Program.h"
#include "RecordSettings.h"
#include "ReplaySettings.h"
#include "slalom/spline/WaypointFile.h"

namespace slalom::doctor
{
namespace
{
using mrpt_io::Finding;
using mrpt_io::Severity;

constexpr const char* kIntroduction = R"(# Configuration

Printed by `slalom-doctor --config-reference`; a test keeps this file and the programs equal.

* Settings are INI files: `[section]`, `key = value`, comments behind `//`, `#` or `;`. Every key may
  be left out and then has the default given here. `configs/slalom.ini` holds the ones to begin with.
* Reading is strict. Unknown sections and keys, malformed or non-finite numbers, values outside the
  allowed range, duplicate keys and contradictions between keys are errors (exit code 2) that name
  file, line, section, key, value and what is allowed. `slalom-doctor --config FILE` checks a file.
* Precedence, lowest first: defaults, files given by `-c` in their order, `--set section.key=value`.
  Where a program has an option for the same thing (`--mission`, `--speed`, ...), the option wins.
  `effective.ini` in the output folder holds every value of a run and where it came from.
* `@define NAME value` in a file, then `${NAME}` in a value of that file.
* A path in a file is relative to that file; a path on the command line to the working directory.
* `[CAbstractNavigator]` belongs to MRPT; the navigator plugin checks it when it is loaded.

)";

std::vector<std::string> linesOf(const std::string& text)
{
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

/// Settings that are good, and the files that they name.
std::vector<Finding> examine(const app::ReplaySettings& settings)
{
  std::size_t keys = 0;
  const auto sections = settings.document.sections();
  for (const std::string& section : sections) keys += settings.document.keys(section).size();
  std::vector<Finding> findings{{Severity::Ok, "configuration: " + std::to_string(sections.size()) +
                                                   " sections, " + std::to_string(keys) + " keys"}};
  if (const auto mission = settings.missionFile(); !mission.empty())
  {
    const auto count = spline::readWaypoints(mission).points_W.cols();
    findings.push_back(
        {Severity::Ok, mission.string() + ": " + std::to_string(count) + " waypoints"});
  }
  return findings;
}
}  // namespace

std::vector<Finding> examineConfig(const std::vector<std::string>& files,
                                   const std::vector<std::string>& assignments)
{
  app::CommonOptions common;
  common.configs = files;
  common.assignments = assignments;
  try
  {
    const app::ReplaySettings settings = app::readReplaySettings(common.document());
    (void)app::readFlySettings(common.document());  // each leaves the other's own sections alone
    return examine(settings);
  }
  catch (const std::runtime_error& error)
  {
    std::vector<Finding> findings;
    for (const std::string& line : linesOf(error.what()))
      findings.push_back({Severity::Error, line});
    return findings;
  }
}

std::string configReference()
{
  std::string text = kIntroduction;
  text += "# slalom-replay and the navigator plugin\n\n" + app::describeReplaySettings();
  text +=
      "# slalom-fly\n\nThe sections above without [replay], the sensors of slalom-record, and\n\n" +
      app::describeFlySettings();
  text += "# slalom-record\n\n" + app::describeRecordSettings();
  text.pop_back();  // of two newlines at the end
  return text;
}

}  // namespace slalom::doctor
