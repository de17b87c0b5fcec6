// SPDX-License-Identifier: BSD-3-Clause
/** What every program shares: exit codes, common options, Ctrl-C, and the way from an exception to
 * an exit code. A main() is
 *
 *    int main(int argc, char** argv)
 *    {
 *      Options options;
 *      return slalom::app::runProgram(
 *          argc, argv, "slalom-xyz", "what it does",
 *          [&](CLI::App& app) { app.add_option("--rawlog", options.rawlog); },
 *          [&] { return run(options); });
 *    }
 */
#pragma once

#include <CLI/CLI.hpp>
#include <csignal>
#include <exception>
#include <filesystem>
#include <functional>
#include <iomanip>
#include <iostream>
#include <new>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "slalom/core/TextTable.h"
#include "slalom/mrpt_io/IniDocument.h"
#include "slalom/mrpt_io/RawlogReader.h"

namespace slalom::app
{
/// docs: "Exit codes" of every program.
enum ExitCode : int
{
  kDone = 0,
  kInternalError = 1,
  kUsage = 2,           ///< command line or configuration
  kBadInput = 3,        ///< unreadable, corrupt or unusable
  kGoalNotReached = 4,  ///< the reason is in metrics.json
  kLimitViolated = 5,   ///< a collision, or a limit violated
  kDeadlineMissed = 6,  ///< deadline objective missed
  kRegression = 7,      ///< differs from --verify or a baseline
  kInterrupted = 130
};

/// A command line that parses and makes no sense, or an output that may not be written. Exit code
/// 2.
class UsageError : public std::runtime_error
{
 public:
  using std::runtime_error::runtime_error;
};

namespace detail
{
inline volatile std::sig_atomic_t interrupted = 0;
inline void onInterrupt(int)
{
  interrupted = 1;
  // A second Ctrl-C ends the program at once.
  std::signal(SIGINT, SIG_DFL);
  std::signal(SIGTERM, SIG_DFL);
}
}  // namespace detail

/// True after Ctrl-C: finish the report and return kInterrupted.
[[nodiscard]] inline bool interrupted()
{
  return detail::interrupted != 0;
}

/// For numeric options: a finite number within bounds. CLI's own checks let nan pass, and -1 for
/// 2^64 - 1.
[[nodiscard]] inline CLI::Validator number(double low, double high)
{
  const auto check = [low, high](const std::string& text) -> std::string
  {
    const auto value = core::parseNumber(text);
    if (value && *value >= low && *value <= high) return {};
    std::ostringstream message;
    message << text << ": a number from " << std::setprecision(16) << low << " to " << high
            << " is needed";
    return message.str();
  };
  return {check, "", "number"};
}
/// Likewise for whole numbers; the largest that a double holds exactly is 2^53.
[[nodiscard]] inline CLI::Validator wholeNumber(double low, double high = 9007199254740992.0)
{
  const auto check = [low, high](const std::string& text) -> std::string
  {
    const bool digits = !text.empty() && text.find_first_not_of("0123456789") == std::string::npos;
    const auto value = core::parseNumber(text);
    if (digits && value && *value >= low && *value <= high) return {};
    std::ostringstream message;
    message << text << ": a whole number from " << std::setprecision(16) << low << " to " << high
            << " is needed";
    return message.str();
  };
  return {check, "", "whole number"};
}

/// The options that most programs have.
struct CommonOptions
{
  std::vector<std::string> configs;      ///< -c, --config; later files win
  std::vector<std::string> assignments;  ///< --set section.key=value
  std::filesystem::path out;             ///< -o, --out
  bool quiet = false;
  bool overwrite = false;  ///< -w
  std::string log_level = "warning";

  void addTo(CLI::App& app)
  {
    // One value per occurrence, so that a positional argument may follow.
    app.add_option("-c,--config", configs, "INI file; may be repeated, later files win")
        ->allow_extra_args(false);
    app.add_option("--set", assignments, "section.key=value, wins over files; may be repeated")
        ->allow_extra_args(false);
    app.add_option("-o,--out", out, "output folder");
    app.add_flag("-q,--quiet", quiet, "no progress");
    app.add_flag("-w,--overwrite", overwrite, "existing output may be replaced");
    app.add_option("--log-level", log_level, "debug, info, warning or error")
        ->check(CLI::IsMember({"debug", "info", "warning", "error"}));
  }

  /// All files and assignments in order. @throws mrpt_io::ConfigError
  [[nodiscard]] mrpt_io::IniDocument document() const
  {
    mrpt_io::IniDocument all;
    for (const std::string& file : configs) all.overlay(mrpt_io::IniDocument::read(file));
    for (const std::string& assignment : assignments) all.set(assignment);
    return all;
  }
};

/** Parses the command line (--help and --version print and end with 0, usage errors with 2), runs,
 * and turns exceptions into one line on stderr and an exit code.
 *  @param configure adds the program's options
 *  @param run returns an exit code */
inline int runProgram(int argc, char** argv, const std::string& name, const std::string& purpose,
                      const std::function<void(CLI::App&)>& configure,
                      const std::function<int()>& run)
{
  const auto complain = [&](const std::string& what, int code)
  {
    std::cerr << name << ": " << what << "\n";
    return code;
  };
  CLI::App app(purpose, name);
  app.set_version_flag("--version", name + " " SLALOM_VERSION);
  try
  {
    configure(app);
    app.parse(argc, argv);
  }
  catch (const CLI::ParseError& e)
  {
    return app.exit(e) == 0 ? kDone : kUsage;
  }
  std::signal(SIGINT, detail::onInterrupt);
  std::signal(SIGTERM, detail::onInterrupt);
  try
  {
    const int code = run();
    std::cout.flush();
    return std::cout ? code : complain("standard output cannot be written", kInternalError);
  }
  catch (const UsageError& e)
  {
    return complain(e.what(), kUsage);
  }
  catch (const mrpt_io::ConfigError& e)
  {
    return complain(e.what(), kUsage);
  }
  catch (const mrpt_io::RawlogError& e)
  {
    return complain(e.what(), kBadInput);
  }
  catch (const std::bad_alloc&)
  {
    return complain("out of memory", kInternalError);
  }
  catch (const std::exception& e)
  {
    return complain(std::string("internal error: ") + e.what(), kInternalError);
  }
  catch (...)
  {
    return complain("internal error: unknown", kInternalError);
  }
}

}  // namespace slalom::app
