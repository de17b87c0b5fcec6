// SPDX-License-Identifier: BSD-3-Clause
#include "Tables.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>

namespace slalom::experiment
{
namespace
{
namespace fs = std::filesystem;

/// Short for a person: four digits that count.
std::string shown(std::optional<double> value)
{
  if (!value) return "-";
  char text[40];
  const double size = std::abs(*value);
  const int decimals = size >= 100.0 ? 1 : size >= 10.0 ? 2 : 3;
  std::snprintf(text, sizeof text, "%.*f",
                *value == std::round(*value) && size < 1e9 ? 0 : decimals, *value);
  return text;
}

std::string exact(std::optional<double> value)
{
  if (!value) return "";
  char text[40];
  std::snprintf(text, sizeof text, "%.9g", *value);
  return text;
}

std::string cell(std::string text)
{
  for (char& c : text)
    if (c == '|' || c == '\n' || c == '\r') c = ' ';
  return text;
}

std::string row(const std::vector<std::string>& cells)
{
  std::string line = "|";
  for (const std::string& text : cells) line += " " + (text.empty() ? "-" : cell(text)) + " |";
  return line + "\n";
}

std::string header(const std::vector<std::string>& cells)
{
  std::string line = row(cells) + "|";
  for (std::size_t i = 0; i < cells.size(); ++i) line += "---|";
  return line + "\n";
}

std::string csvText(const std::string& text)
{
  std::string quoted = "\"";
  for (const char c : text)
  {
    if (c == '"') quoted += '"';
    quoted += c == '\n' || c == '\r' ? ' ' : c;
  }
  return quoted + "\"";
}

std::vector<std::string> columnsOf(const Experiment& experiment)
{
  auto columns = wordsOf(experiment.general.columns);
  return columns.empty() ? std::vector<std::string>{"success", "contacts", "clearance_m",
                                                    "length_m", "duration_s"}
                         : columns;
}

std::string verdictTable(const Results& results)
{
  std::string text = header({"acceptance number", "wanted", "figure", "flights", "verdict"});
  for (const Verdict& v : results.verdicts)
    text += row({v.limit.text.empty() ? v.limit.name : v.limit.text,
                 v.limit.statistic + " " + v.limit.metric + " " + v.limit.must, shown(v.value),
                 std::to_string(v.measured) + " of " + std::to_string(v.planned),
                 toString(v.judgement)});
  return text;
}

std::string groupTable(const Results& results)
{
  const auto columns = columnsOf(results.experiment);
  std::vector<std::string> names{"group", "flown"};
  for (const std::string& column : columns) names.push_back(column + ", mean");
  std::string text = header(names);
  for (const Group& group : results.experiment.groups)
  {
    const auto of = [&](const std::string& metric)
    { return statisticOf(results.flights, group.name, metric, "mean", false); };
    const Statistic flown = of("success");
    std::vector<std::string> cells{
        group.name, std::to_string(flown.measured) + " of " + std::to_string(flown.planned)};
    for (const std::string& column : columns) cells.push_back(shown(of(column).value));
    text += row(cells);
  }
  for (const Group& group : results.experiment.groups)
    if (!group.note.empty()) text += "\n* " + group.name + ": " + group.note;
  return text + "\n";
}

std::string flightTable(const Results& results)
{
  const auto columns = columnsOf(results.experiment);
  std::vector<std::string> names{"flight", "result"};
  names.insert(names.end(), columns.begin(), columns.end());
  std::string text = header(names);
  for (const FlownFlight& flight : results.flights)
  {
    std::vector<std::string> cells{
        flight.flown ? "[" + flight.planned.name + "](flights/" + flight.planned.name + "/)"
                     : flight.planned.name,
        flight.result};
    for (const std::string& column : columns) cells.push_back(shown(flight.figure(column)));
    text += row(cells);
  }
  return text;
}

/// One overview per group: of the first flight that did not end as it should, else of the first.
std::string pictures(const Results& results, const fs::path& out)
{
  std::string text;
  for (const Group& group : results.experiment.groups)
  {
    const FlownFlight* chosen = nullptr;
    for (const FlownFlight& flight : results.flights)
    {
      const std::string file = "flights/" + flight.planned.name + "/overview.png";
      if (flight.planned.group != group.name || !fs::exists(out / file)) continue;
      const bool as_expected = flight.figure("expected").value_or(0.0) > 0.5;
      if (!chosen) chosen = &flight;
      if (!as_expected)
      {
        chosen = &flight;
        break;
      }
    }
    if (chosen)
      text += "\n![" + chosen->planned.name + ": " + chosen->result + "](flights/" +
              chosen->planned.name + "/overview.png)\n";
  }
  return text;
}

std::string remarks(const std::vector<Remark>& all)
{
  std::string text;
  for (const Remark& remark : all) text += "* " + remark.name + ": " + remark.text + "\n";
  return text;
}

std::string hardware()
{
  std::ifstream cpuinfo("/proc/cpuinfo");
  std::string model = "unknown processor";
  int cores = 0;
  for (std::string line; std::getline(cpuinfo, line);)
    if (line.starts_with("model name"))
    {
      ++cores;
      if (const auto colon = line.find(": "); colon != std::string::npos)
        model = line.substr(colon + 2);
    }
  return model + ", " + std::to_string(cores) + " cores";
}

/// Our row in the table of peers.
std::string ownRow(const Results& results, const Group& group)
{
  const auto of = [&](const char* metric, const char* statistic, bool successes)
  { return statisticOf(results.flights, group.name, metric, statistic, successes); };
  const Statistic success = of("success", "sum", false);
  const std::string reached =
      success.value ? shown(success.value) + "/" + std::to_string(success.measured) : "-";
  return row({"**Slalom, " + group.name + "**", "this run", reached,
              shown(of("planning_ms", "mean", false).value),
              shown(of("length_m", "mean", true).value), shown(of("length_m", "max", true).value),
              shown(of("length_m", "min", true).value), shown(of("ratio", "mean", true).value),
              shown(of("duration_s", "mean", true).value)});
}

std::string peerTable(const Results& results)
{
  if (results.experiment.peers.empty()) return {};
  std::string text =
      "\n## Other methods\n\nLengths, ratio and time: of the flights that reached the goal.\n\n" +
      header({"method", "source", "success", "planning ms", "length mean m", "max m", "min m",
              "to shortest", "time s"});
  for (const Peer& p : results.experiment.peers)
    text += row({p.label, p.source, p.success, p.planning_ms, p.length_mean_m, p.length_max_m,
                 p.length_min_m, p.ratio, p.time_s});
  for (const Group& group : results.experiment.groups) text += ownRow(results, group);
  return text;
}
}  // namespace

std::string summaryLine(const Results& results)
{
  const auto met = std::count_if(results.verdicts.begin(), results.verdicts.end(),
                                 [](const auto& v) { return v.judgement == Judgement::Met; });
  return std::to_string(met) + " of " + std::to_string(results.verdicts.size()) +
         " acceptance numbers met" +
         (results.experiment.missing.empty()
              ? ""
              : ", " + std::to_string(results.experiment.missing.size()) + " flights missing");
}

std::string tableCsv(const Results& results)
{
  std::string text = "flight,group,world,seed,result";
  for (const std::string& name : figureNames()) text += "," + name;
  text += "\n";
  for (const FlownFlight& flight : results.flights)
  {
    const PlannedFlight& p = flight.planned;
    text += csvText(p.name) + "," + csvText(p.group) + "," + csvText(p.world) + "," +
            std::to_string(p.seed) + "," + csvText(flight.result);
    for (const std::string& name : figureNames()) text += "," + exact(flight.figure(name));
    text += "\n";
  }
  return text;
}

std::string tableMarkdown(const Results& results, const fs::path& out)
{
  const Experiment& experiment = results.experiment;
  std::string text = "# " + experiment.general.title + "\n\n`" + results.command + "` on " +
                     hardware() + ".\n\n" + summaryLine(results) + ".\n\n" + verdictTable(results);
  if (!experiment.missing.empty())
    text += "\n## Not flown: the simulator cannot do it yet\n\n" + remarks(experiment.missing);
  return text + "\n## Groups\n\n" + groupTable(results) + "\n## Flights\n\n" +
         flightTable(results) + "\n## Pictures\n" + pictures(results, out);
}

std::string comparisonMarkdown(const Results& results)
{
  const Experiment& experiment = results.experiment;
  std::string text = "# " + experiment.general.title + ": the paper's figures and ours\n\n" +
                     header({"quantity", "paper", "ours", "flights"});
  for (const Comparison& c : experiment.comparisons)
  {
    const Statistic s =
        statisticOf(results.flights, c.groups, c.metric, c.statistic, c.successes_only);
    text += row({c.text.empty() ? c.name : c.text, c.paper, shown(s.value),
                 std::to_string(s.measured) + " of " + std::to_string(s.planned)});
  }
  text += peerTable(results);
  if (!experiment.differences.empty())
    text += "\n## What differs from the paper\n\n" + remarks(experiment.differences);
  return text + "\nOurs: " + hardware() + "; " + summaryLine(results) + ".\n";
}

}  // namespace slalom::experiment
