// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "Experiment.h"
#include "Figures.h"

namespace slalom::experiment
{
/// "<= 0.15"
struct Bound
{
  enum class Relation
  {
    AtMost,
    AtLeast,
    Equal
  };
  Relation relation = Relation::AtMost;
  double value = 0.0;

  [[nodiscard]] static std::optional<Bound> parse(const std::string& text);
  [[nodiscard]] bool holds(double x) const;
};

/// What a statistic was taken over.
struct Statistic
{
  std::optional<double> value;  ///< nullopt: no flight has the figure
  std::size_t measured = 0;     ///< flights that have it
  std::size_t planned = 0;      ///< flights that should
};

/** mean, min, max or sum of a figure over the flights of some groups (empty = all).
 *  @param successes_only flights that did not succeed are not asked; they are not planned either */
[[nodiscard]] Statistic statisticOf(const std::vector<FlownFlight>& flights,
                                    const std::string& groups, const std::string& metric,
                                    const std::string& statistic, bool successes_only);

enum class Judgement
{
  Met,
  NotMet,
  NotMeasured  ///< a flight is missing, or has no such figure
};
[[nodiscard]] const char* toString(Judgement judgement);

struct Verdict
{
  Limit limit;
  Judgement judgement = Judgement::NotMeasured;
  std::optional<double> value;
  std::size_t measured = 0, planned = 0;
};

/// Each acceptance number. A number over flights of which one is missing is not measured, unless
/// what is there already breaks it.
[[nodiscard]] std::vector<Verdict> judge(const std::vector<Limit>& limits,
                                         const std::vector<FlownFlight>& flights);

/// All met, and at least one.
[[nodiscard]] bool allMet(const std::vector<Verdict>& verdicts);

}  // namespace slalom::experiment
