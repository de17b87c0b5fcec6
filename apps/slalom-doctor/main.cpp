// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <filesystem>
#include <iostream>

#include "Config.h"
#include "Program.h"
#include "System.h"
#include "slalom/mrpt_io/Diagnosis.h"
#include "slalom/mrpt_io/MemoryLimit.h"

namespace
{
using namespace slalom;

struct Options
{
  std::vector<std::filesystem::path> rawlogs;
  std::vector<std::string> configs, assignments;
  bool system = false, reference = false, quiet = false;
};

/// Prints findings, one line each. @return true when one of them is an error
bool print(const std::vector<mrpt_io::Finding>& findings, bool quiet)
{
  bool wrong = false;
  for (const auto& [severity, text] : findings)
  {
    const bool good = severity == mrpt_io::Severity::Ok;
    wrong |= severity == mrpt_io::Severity::Error;
    if (quiet && good) continue;
    std::string line = text;
    std::replace(line.begin(), line.end(), '\n', ' ');
    const char* word = good                                     ? "ok: "
                       : severity == mrpt_io::Severity::Warning ? "warn: "
                                                                : "error: ";
    std::cout << word << line << "\n";
  }
  return wrong;
}

int run(const Options& options)
{
  if (options.reference)
  {
    std::cout << doctor::configReference();
    return app::kDone;
  }
  const bool config = !options.configs.empty() || !options.assignments.empty();
  if (options.rawlogs.empty() && !config && !options.system)
    throw app::UsageError("nothing to examine; give --rawlog, --config or --system");
  // A damaged length field must not take the machine with it.
  mrpt_io::limitMemory(std::uint64_t(4) << 30);
  int code = app::kDone;
  if (options.system) (void)print(doctor::examineSystem(), options.quiet);
  for (const auto& file : options.rawlogs)
    if (print(mrpt_io::diagnoseRawlog(file), options.quiet)) code = app::kBadInput;
  if (config && print(doctor::examineConfig(options.configs, options.assignments), options.quiet))
    code = app::kUsage;
  return code;
}
}  // namespace

int main(int argc, char** argv)
{
  Options options;
  return app::runProgram(
      argc, argv, "slalom-doctor",
      "Says what is wrong with a rawlog, a configuration, this machine.",
      [&](CLI::App& app)
      {
        app.add_option("--rawlog", options.rawlogs, "rawlog to examine; may be repeated")
            ->allow_extra_args(false);
        app.add_option("-c,--config", options.configs,
                       "INI file of a replay to examine; may be repeated, later files win")
            ->allow_extra_args(false);
        app.add_option("--set", options.assignments, "section.key=value on top of --config")
            ->allow_extra_args(false);
        app.add_flag("--system", options.system, "examine this build and machine");
        app.add_flag("--config-reference", options.reference,
                     "print every key of every program as Markdown and stop");
        app.add_flag("-q,--quiet", options.quiet, "print warnings and errors only");
      },
      [&] { return run(options); });
}
