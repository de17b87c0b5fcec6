// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>

namespace slalom::replay
{
struct Verdict
{
  bool equal = false;
  std::string message;  ///< names the first differing cycle and column, or the first differing file
};

/** Compares two output folders: cycles.csv row by row, commands.csv and the TUM files byte by byte.
 *  @throws std::runtime_error if `earlier` holds no cycles.csv */
[[nodiscard]] Verdict compareRuns(const std::filesystem::path& earlier,
                                  const std::filesystem::path& now);

}  // namespace slalom::replay
