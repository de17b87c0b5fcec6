// SPDX-License-Identifier: BSD-3-Clause
/** What an experiment is: everything that its INI file says. Section and key names are those of
 * the structs; configs/experiments/README.md says what they are for. */
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "slalom/core/Fields.h"
#include "slalom/mrpt_io/IniDocument.h"

namespace slalom::experiment
{
/// INI section [experiment].
struct General
{
  std::string title = "experiment";
  std::string columns;  ///< names of figures, in order of the table
  std::string configs, settings;
  std::string shortest_exceptions;
  bool record = false;

  template <class Self, class Visit>
  static void fields(Self& c, Visit&& v)
  {
    v("title", c.title, "heading of the table");
    v("columns", c.columns, "figures of the table, separated by blanks");
    v("configs", c.configs, "settings files of slalom-fly for every flight, in order");
    v("settings", c.settings,
      "section.key=value for every flight, separated by blanks; a group's own come after");
    v("record", c.record, "write flight.rawlog into every flight's folder, for slalom-replay");
    v("shortest_exceptions", c.shortest_exceptions,
      "worlds of --data that are compared with the shortest path for 0.5 m instead of 0.3 m");
  }
};

/// INI section [group.NAME]: flights that differ in world, waypoints and seed only.
struct Group
{
  std::string name;
  std::string configs, settings;
  std::string worlds, data_worlds;
  std::string waypoints;
  std::string start, goal;
  std::string seeds = "1";
  std::string expect = "GOAL_REACHED";
  std::string note;
  double time_limit_s = 0.0;

  template <class Self, class Visit>
  static void fields(Self& c, Visit&& v)
  {
    using core::Range;
    v("configs", c.configs, "settings files of slalom-fly, in order, after those of [experiment]");
    v("settings", c.settings, "section.key=value of slalom-fly, separated by blanks");
    v("worlds", c.worlds, "world files, or forest:SEED:DENSITY for a generated one");
    v("data_worlds", c.data_worlds, "with --data these files of it are flown instead");
    v("waypoints", c.waypoints, "waypoint files; each is flown in each world");
    v("start", c.start, "x,y,z; without it the first waypoint");
    v("goal", c.goal, "x,y,z; without it the last waypoint");
    v("seeds", c.seeds, "such as 1-5, or numbers separated by blanks");
    v("expect", c.expect, "how a good flight ends: names of results, separated by blanks");
    v("note", c.note, "a remark for the table");
    v("time_limit_s", c.time_limit_s, Range{0.0, 1e5}, "simulated time; 0 = what configs say");
  }
};

/// INI section [limit.NAME]: an acceptance number.
struct Limit
{
  std::string name;
  std::string text, groups, metric, relative_to;
  std::string statistic = "mean";
  std::string must;  ///< "<= 0.15", ">= 60", "== 0"
  bool successes_only = false;

  template <class Self, class Visit>
  static void fields(Self& c, Visit&& v)
  {
    v("text", c.text, "in words");
    v("groups", c.groups, "names of groups, separated by blanks; empty = all");
    v("metric", c.metric, "figure of a flight");
    v("statistic", c.statistic, "mean, min, max or sum over the flights");
    v("relative_to", c.relative_to, "groups whose figure this one is divided by");
    v("must", c.must, "<=, >= or == and a number");
    v("successes_only", c.successes_only, "flights that reached their goal only");
  }
};

/// INI section [compare.NAME]: a figure of the paper beside ours.
struct Comparison
{
  std::string name;
  std::string text, paper, groups, metric;
  std::string statistic = "mean";
  bool successes_only = false;

  template <class Self, class Visit>
  static void fields(Self& c, Visit&& v)
  {
    v("text", c.text, "what is compared");
    v("paper", c.paper, "the paper's figure, with its unit");
    v("groups", c.groups, "names of groups, separated by blanks; empty = all");
    v("metric", c.metric, "figure of a flight");
    v("statistic", c.statistic, "mean, min, max or sum over the flights");
    v("successes_only", c.successes_only, "flights that reached their goal only");
  }
};

/// INI section [peer.NAME]: what another method achieved, as it was published or measured.
struct Peer
{
  std::string name;
  std::string label, source;
  std::string success, planning_ms, length_mean_m, length_max_m, length_min_m, ratio, time_s;

  template <class Self, class Visit>
  static void fields(Self& c, Visit&& v)
  {
    v("label", c.label, "name of the method");
    v("source", c.source, "where the figures come from");
    v("success", c.success, "share, or reached of flown");
    v("planning_ms", c.planning_ms, "planning time per call");
    v("length_mean_m", c.length_mean_m, "mean flown length");
    v("length_max_m", c.length_max_m, "largest flown length");
    v("length_min_m", c.length_min_m, "smallest flown length");
    v("ratio", c.ratio, "length to the shortest path");
    v("time_s", c.time_s, "flight time");
  }
};

/// INI sections [missing.NAME], a flight that cannot be flown yet, and [differs.NAME], what is not
/// as it was in the paper.
struct Remark
{
  std::string name, text;

  template <class Self, class Visit>
  static void fields(Self& c, Visit&& v)
  {
    v("text", c.text, "in words");
  }
};

struct Experiment
{
  std::string name;              ///< of the file
  std::filesystem::path folder;  ///< that relative paths begin at
  General general;
  std::vector<Group> groups;
  std::vector<Limit> limits;
  std::vector<Comparison> comparisons;
  std::vector<Peer> peers;
  std::vector<Remark> missing, differences;
  std::string effective;  ///< INI text of all that

  [[nodiscard]] const Group* find(const std::string& group) const;
};

/// The file of a shipped experiment ("e1"), or the path itself. @throws UsageError
[[nodiscard]] std::filesystem::path experimentFile(const std::string& name);

/** The experiment of a file, with what -c and --set change of it. `--set group.NAME.key=value`: the
 * key is what follows the last dot.
 *  @throws mrpt_io::ConfigError naming file, line, section, key and value, also for names of
 * figures, groups, statistics and results that do not exist */
[[nodiscard]] Experiment readExperiment(const std::filesystem::path& file,
                                        const std::vector<std::string>& overlays = {},
                                        const std::vector<std::string>& assignments = {});

/// Blank-separated words.
[[nodiscard]] std::vector<std::string> wordsOf(const std::string& text);

/// "1-3 7" -> 1, 2, 3, 7. @throws mrpt_io::ConfigError
[[nodiscard]] std::vector<std::uint64_t> seedsOf(const std::string& text);

}  // namespace slalom::experiment
