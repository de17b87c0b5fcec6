// SPDX-License-Identifier: BSD-3-Clause
#include "Verdict.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "slalom/core/TextTable.h"

namespace slalom::experiment
{
namespace
{
double reduced(const std::vector<double>& values, const std::string& statistic)
{
  if (statistic == "min") return *std::min_element(values.begin(), values.end());
  if (statistic == "max") return *std::max_element(values.begin(), values.end());
  const double sum = std::accumulate(values.begin(), values.end(), 0.0);
  return statistic == "sum" ? sum : sum / static_cast<double>(values.size());
}

/// What is still to come can only make it worse.
bool brokenForGood(const Limit& limit, const Bound& bound, double value)
{
  const bool grows = limit.statistic == "max";
  const bool falls = limit.statistic == "min";
  return limit.relative_to.empty() && !bound.holds(value) &&
         ((grows && bound.relation == Bound::Relation::AtMost) ||
          (falls && bound.relation == Bound::Relation::AtLeast));
}

Verdict judgeOne(const Limit& limit, const std::vector<FlownFlight>& flights)
{
  const Statistic own =
      statisticOf(flights, limit.groups, limit.metric, limit.statistic, limit.successes_only);
  Verdict verdict{limit, Judgement::NotMeasured, own.value, own.measured, own.planned};
  bool complete = own.value.has_value() && own.measured == own.planned;
  if (!limit.relative_to.empty())
  {
    const Statistic base = statisticOf(flights, limit.relative_to, limit.metric, limit.statistic,
                                       limit.successes_only);
    complete = complete && base.value && base.measured == base.planned && *base.value > 0.0;
    verdict.value = complete ? std::optional(*own.value / *base.value) : std::nullopt;
  }
  const auto bound = Bound::parse(limit.must);
  if (!bound || !verdict.value) return verdict;
  if (complete)
    verdict.judgement = bound->holds(*verdict.value) ? Judgement::Met : Judgement::NotMet;
  else if (brokenForGood(limit, *bound, *verdict.value))
    verdict.judgement = Judgement::NotMet;
  return verdict;
}
}  // namespace

std::optional<Bound> Bound::parse(const std::string& text)
{
  const std::string relation = text.substr(0, 2);
  Bound bound;
  if (relation == "<=")
    bound.relation = Relation::AtMost;
  else if (relation == ">=")
    bound.relation = Relation::AtLeast;
  else if (relation == "==")
    bound.relation = Relation::Equal;
  else
    return std::nullopt;
  const auto number = core::parseNumber(core::trimmed(std::string_view(text).substr(2)));
  if (!number) return std::nullopt;
  bound.value = *number;
  return bound;
}

bool Bound::holds(double x) const
{
  switch (relation)
  {
    case Relation::AtMost:
      return x <= value;
    case Relation::AtLeast:
      return x >= value;
    case Relation::Equal:
      return std::abs(x - value) <= 1e-9 * std::max(1.0, std::abs(value));
  }
  return false;
}

Statistic statisticOf(const std::vector<FlownFlight>& flights, const std::string& groups,
                      const std::string& metric, const std::string& statistic, bool successes_only)
{
  const std::vector<std::string> wanted = wordsOf(groups);
  Statistic result;
  std::vector<double> values;
  for (const FlownFlight& flight : flights)
  {
    const bool mine = wanted.empty() ||
                      std::find(wanted.begin(), wanted.end(), flight.planned.group) != wanted.end();
    const bool asked =
        !successes_only || !flight.flown || flight.figure("success").value_or(0.0) > 0.5;
    if (!mine || !asked) continue;
    ++result.planned;
    if (const auto value = flight.figure(metric)) values.push_back(*value);
  }
  result.measured = values.size();
  if (!values.empty()) result.value = reduced(values, statistic);
  return result;
}

const char* toString(Judgement judgement)
{
  switch (judgement)
  {
    case Judgement::Met:
      return "met";
    case Judgement::NotMet:
      return "NOT MET";
    case Judgement::NotMeasured:
      return "not measured";
  }
  return "?";
}

std::vector<Verdict> judge(const std::vector<Limit>& limits,
                           const std::vector<FlownFlight>& flights)
{
  std::vector<Verdict> verdicts;
  for (const Limit& limit : limits) verdicts.push_back(judgeOne(limit, flights));
  return verdicts;
}

bool allMet(const std::vector<Verdict>& verdicts)
{
  return !verdicts.empty() &&
         std::all_of(verdicts.begin(), verdicts.end(),
                     [](const Verdict& v) { return v.judgement == Judgement::Met; });
}

}  // namespace slalom::experiment
