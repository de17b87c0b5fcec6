// SPDX-License-Identifier: BSD-3-Clause
#include "Experiment.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <sstream>

#include "Figures.h"
#include "Program.h"
#include "Verdict.h"
#include "slalom/mrpt_io/ConfigBinder.h"

namespace slalom::experiment
{
namespace
{
namespace fs = std::filesystem;
using mrpt_io::ConfigError;

constexpr std::uint64_t kMostSeeds = 10000;

[[noreturn]] void refuse(const std::string& section, const std::string& key,
                         const std::string& value, const std::string& why)
{
  throw ConfigError("[" + section + "] " + key + " = " + value + ": " + why);
}

/// All sections PREFIX.NAME, in order of their names.
template <class Section>
std::vector<Section> sectionsOf(const mrpt_io::IniDocument& document, mrpt_io::ConfigBinder& binder,
                                const std::string& prefix)
{
  std::vector<Section> found;
  for (const std::string& name : document.sections())
  {
    if (!name.starts_with(prefix + ".") || name.size() == prefix.size() + 1) continue;
    Section section;
    section.name = name.substr(prefix.size() + 1);
    binder.bind(name, section);
    found.push_back(std::move(section));
  }
  return found;
}

void checkMetric(const std::string& section, const std::string& key, const std::string& metric)
{
  const auto& known = figureNames();
  if (std::find(known.begin(), known.end(), metric) != known.end()) return;
  std::string all;
  for (const std::string& name : known) all += (all.empty() ? "" : ", ") + name;
  refuse(section, key, metric, "no such figure; there are " + all);
}

void checkGroups(const Experiment& experiment, const std::string& section, const std::string& key,
                 const std::string& groups)
{
  for (const std::string& group : wordsOf(groups))
  {
    const bool missing = std::any_of(experiment.missing.begin(), experiment.missing.end(),
                                     [&](const Remark& r) { return r.name == group; });
    if (!experiment.find(group) && !missing)
      refuse(section, key, groups, "there is no section [group." + group + "]");
  }
}

void checkStatistic(const std::string& section, const std::string& statistic)
{
  constexpr std::array kKnown{"mean", "min", "max", "sum"};
  if (std::find(kKnown.begin(), kKnown.end(), statistic) == kKnown.end())
    refuse(section, "statistic", statistic, "mean, min, max or sum");
}

void checkExpectation(const Group& group)
{
  constexpr std::array kKnown{"GOAL_REACHED", "GOAL_BLOCKED", "UNREACHABLE",
                              "FAILED",       "TIMEOUT",      "COLLISION"};
  for (const std::string& word : wordsOf(group.expect))
    if (std::find(kKnown.begin(), kKnown.end(), word) == kKnown.end())
      refuse("group." + group.name, "expect", word, "no such result");
}

void checkGroup(const Group& group)
{
  const std::string section = "group." + group.name;
  // It becomes part of a path.
  if (group.name.find_first_of("/\\ ,") != std::string::npos || group.name.starts_with('.'))
    refuse(section, "", group.name, "a name without blanks, commas and slashes is needed");
  if (wordsOf(group.worlds).empty()) refuse(section, "worlds", group.worlds, "a world is needed");
  if (wordsOf(group.waypoints).empty() && (group.start.empty() || group.goal.empty()))
    refuse(section, "goal", group.goal, "waypoints, or start and goal, are needed");
  for (const std::string& word : wordsOf(group.settings))
    if (word.find('=') == std::string::npos || word.find('.') > word.find('='))
      refuse(section, "settings", word, "section.key=value is needed");
  if (seedsOf(group.seeds).empty()) refuse(section, "seeds", group.seeds, "a seed is needed");
  checkExpectation(group);
}

void check(const Experiment& experiment)
{
  if (experiment.groups.empty()) throw ConfigError("an experiment needs a section [group.NAME]");
  for (const std::string& column : wordsOf(experiment.general.columns))
    checkMetric("experiment", "columns", column);
  for (const Group& group : experiment.groups) checkGroup(group);
  for (const Limit& limit : experiment.limits)
  {
    const std::string section = "limit." + limit.name;
    checkMetric(section, "metric", limit.metric);
    checkGroups(experiment, section, "groups", limit.groups);
    checkGroups(experiment, section, "relative_to", limit.relative_to);
    checkStatistic(section, limit.statistic);
    if (!Bound::parse(limit.must))
      refuse(section, "must", limit.must, "<=, >= or == and a number are needed");
  }
  for (const Comparison& comparison : experiment.comparisons)
  {
    const std::string section = "compare." + comparison.name;
    checkMetric(section, "metric", comparison.metric);
    checkGroups(experiment, section, "groups", comparison.groups);
    checkStatistic(section, comparison.statistic);
  }
}

/// Like IniDocument::set, but the section's name may have dots.
mrpt_io::IniDocument assignmentOf(const std::string& assignment)
{
  const std::size_t equal = assignment.find('=');
  const std::size_t dot = equal == std::string::npos || equal == 0
                              ? std::string::npos
                              : assignment.rfind('.', equal - 1);
  if (dot == std::string::npos || assignment.find('\n') != std::string::npos)
    throw ConfigError("--set " + assignment + ": expected section.key=value");
  return mrpt_io::IniDocument::parse(
      "[" + assignment.substr(0, dot) + "]\n" + assignment.substr(dot + 1) + "\n", "--set");
}

std::uint64_t seedOf(std::string_view word, const std::string& text)
{
  std::uint64_t seed = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), seed);
  if (error != std::errc() || end != word.data() + word.size())
    throw ConfigError("seeds = " + text + ": whole numbers or ranges such as 1-5 are needed");
  return seed;
}
}  // namespace

const Group* Experiment::find(const std::string& group) const
{
  const auto found =
      std::find_if(groups.begin(), groups.end(), [&](const Group& g) { return g.name == group; });
  return found == groups.end() ? nullptr : &*found;
}

std::vector<std::string> wordsOf(const std::string& text)
{
  std::istringstream stream(text);
  std::vector<std::string> words;
  for (std::string word; stream >> word;) words.push_back(word);
  return words;
}

std::vector<std::uint64_t> seedsOf(const std::string& text)
{
  std::vector<std::uint64_t> seeds;
  for (const std::string& word : wordsOf(text))
  {
    const std::size_t dash = word.find('-');
    const std::uint64_t first = seedOf(std::string_view(word).substr(0, dash), text);
    const std::uint64_t last =
        dash == std::string::npos ? first : seedOf(std::string_view(word).substr(dash + 1), text);
    if (last < first || last - first >= kMostSeeds)
      throw ConfigError("seeds = " + text + ": a range of 1 to 10000 seeds is needed");
    for (std::uint64_t seed = first; seed <= last; ++seed) seeds.push_back(seed);
  }
  return seeds;
}

fs::path experimentFile(const std::string& name)
{
  if (fs::path(name).extension() == ".ini") return name;
  std::error_code ignored;
  const fs::path self = fs::read_symlink("/proc/self/exe", ignored);
  const std::array<fs::path, 2> places{
      self.parent_path().parent_path() / "share/slalom/configs/experiments",
      SLALOM_CONFIG_DIR "/experiments"};
  for (const fs::path& place : places)
    if (const fs::path file = place / (name + ".ini"); fs::exists(file, ignored)) return file;
  throw app::UsageError(name + ": no such experiment; e1, e2, e3, e4, gallery, soak, or a file");
}

Experiment readExperiment(const fs::path& file, const std::vector<std::string>& overlays,
                          const std::vector<std::string>& assignments)
{
  mrpt_io::IniDocument document = mrpt_io::IniDocument::read(file);
  for (const std::string& overlay : overlays) document.overlay(mrpt_io::IniDocument::read(overlay));
  for (const std::string& assignment : assignments) document.overlay(assignmentOf(assignment));

  Experiment experiment;
  experiment.name = file.stem().string();
  experiment.folder = fs::absolute(file).parent_path();
  mrpt_io::ConfigBinder binder(document);
  binder.bind("experiment", experiment.general);
  experiment.groups = sectionsOf<Group>(document, binder, "group");
  experiment.limits = sectionsOf<Limit>(document, binder, "limit");
  experiment.comparisons = sectionsOf<Comparison>(document, binder, "compare");
  experiment.peers = sectionsOf<Peer>(document, binder, "peer");
  experiment.missing = sectionsOf<Remark>(document, binder, "missing");
  experiment.differences = sectionsOf<Remark>(document, binder, "differs");
  binder.finish();
  try
  {
    check(experiment);
  }
  catch (const ConfigError& error)
  {
    throw ConfigError(file.string() + ": " + error.what());
  }
  experiment.effective = binder.effective();
  return experiment;
}

}  // namespace slalom::experiment
