// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace slalom::mrpt_io
{
enum class Severity
{
  Ok,
  Warning,
  Error
};

/// One thing that is good, suspicious or wrong.
struct Finding
{
  Severity severity = Severity::Ok;
  std::string text;
};

/** Reads a whole rawlog and says what is in it, what is wrong with it, and what a replay could do
 * with it: damage, sensors with count, rate, gaps and time jumps, values that are not finite,
 * classes that are unknown, and last the verdict. Never throws for a bad rawlog: that is a finding.
 */
[[nodiscard]] std::vector<Finding> diagnoseRawlog(const std::filesystem::path& file);

}  // namespace slalom::mrpt_io
