// SPDX-License-Identifier: BSD-3-Clause
/** What an experiment leaves: table.csv (one row per flight), table.md (verdict, groups, flights,
 * pictures) and comparison.md (the paper's and peers' figures beside ours). Pure functions. */
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "Experiment.h"
#include "Figures.h"
#include "Verdict.h"

namespace slalom::experiment
{
struct Results
{
  const Experiment& experiment;
  const std::vector<FlownFlight>& flights;
  const std::vector<Verdict>& verdicts;
  std::string command;  ///< that made it
};

/// Every known figure, full precision; an unknown one is an empty cell.
[[nodiscard]] std::string tableCsv(const Results& results);

/// @param out folder that links are relative to
[[nodiscard]] std::string tableMarkdown(const Results& results, const std::filesystem::path& out);

[[nodiscard]] std::string comparisonMarkdown(const Results& results);

/// "met: 3 of 4 acceptance numbers"
[[nodiscard]] std::string summaryLine(const Results& results);

}  // namespace slalom::experiment
