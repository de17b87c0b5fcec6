// SPDX-License-Identifier: BSD-3-Clause
#include "Run.h"

#include <algorithm>
#include <iostream>
#include <map>

#include "Experiment.h"
#include "Figures.h"
#include "FlightPlan.h"
#include "FlightPool.h"
#include "Progress.h"
#include "Tables.h"
#include "Verdict.h"
#include "slalom/core/TextTable.h"
#include "slalom/report/AtomicFile.h"

namespace slalom::experiment
{
namespace
{
namespace fs = std::filesystem;

fs::path besideUs(const char* program)
{
  const fs::path file = fs::read_symlink("/proc/self/exe").parent_path() / program;
  if (!fs::exists(file)) throw std::runtime_error(file.string() + " is not there");
  return file;
}

/// Shortest paths [m] by world, from the meta.csv of a folder of worlds; empty without one.
std::map<std::string, double> shortestPaths(const fs::path& data, const General& general)
{
  std::map<std::string, double> shortest;
  const fs::path file = data / "meta.csv";
  if (data.empty() || !fs::exists(file)) return shortest;
  const auto rows = core::readRows(file, ',');
  const auto exceptions = wordsOf(general.shortest_exceptions);
  const auto columnOf = [&](const char* name)
  {
    const auto& header = rows.front().fields;
    const auto found = std::find(header.begin(), header.end(), name);
    if (found == header.end()) core::failAt(file, 1, std::string("no column ") + name);
    return static_cast<std::size_t>(found - header.begin());
  };
  const std::size_t tight = columnOf("shortest_r0.3"), wide = columnOf("shortest_r0.5");
  for (std::size_t i = 1; i < rows.size(); ++i)
  {
    const std::string& name = rows[i].fields.front();
    const bool exception =
        std::find(exceptions.begin(), exceptions.end(), name) != exceptions.end();
    const double length = core::numberAt(file, rows[i], exception ? wide : tight);
    if (length > 0.0) shortest[name] = length;
  }
  return shortest;
}

fs::path folderOf(const fs::path& out)
{
  if (out.empty()) throw app::UsageError("--out: an output folder is needed");
  return fs::absolute(out);
}

/// @throws UsageError if it cannot be
void makeFolder(const fs::path& folder)
{
  std::error_code error;
  fs::create_directories(folder, error);
  if (error || !fs::is_directory(folder))
    throw app::UsageError("--out " + folder.string() + ": " +
                          (error ? error.message() : std::string("not a folder")));
}

std::string commandOf(const Options& options)
{
  std::string command = "slalom-experiment " + options.experiment;
  for (const std::string& file : options.common.configs) command += " -c " + file;
  for (const std::string& set : options.common.assignments) command += " --set " + set;
  if (!options.data.empty()) command += " --data " + options.data.string();
  if (!options.only.empty()) command += " --only " + options.only;
  return command + " -o " + options.common.out.string();
}

class Campaign
{
 public:
  explicit Campaign(const Options& options)
      : options_(options),
        experiment_(readExperiment(experimentFile(options.experiment), options.common.configs,
                                   options.common.assignments)),
        out_(folderOf(options.common.out)),
        program_(besideUs("slalom-fly"))
  {
    if (!options.data.empty() && !fs::is_directory(options.data))
      throw app::UsageError("--data " + options.data.string() + ": no such folder");
    select();
    makeFolder(out_);
    plan_ = planFlights(experiment_, out_,
                        options.data.empty() ? fs::path() : fs::absolute(options.data), program_);
  }

  int run()
  {
    if (options_.dry_run)
    {
      for (const PlannedFlight& flight : plan_)
        std::cout << flight.name << (finishedFlight(flight) ? " (flown)" : "") << "\n";
      return app::kDone;
    }
    report::writeFileAtomically(out_ / "effective.ini", experiment_.effective);
    const bool complete = fly();
    return conclude(complete);
  }

 private:
  /// Leaves the groups of --only. What is left out stays planned, and is missing in the verdict.
  void select()
  {
    std::string names = options_.only;
    std::replace(names.begin(), names.end(), ',', ' ');
    only_ = wordsOf(names);
    for (const std::string& name : only_)
      if (!experiment_.find(name)) throw app::UsageError("--only " + name + ": no such group");
  }

  bool fly()
  {
    std::vector<const PlannedFlight*> to_fly;
    for (const PlannedFlight& flight : plan_)
    {
      const bool selected =
          only_.empty() || std::find(only_.begin(), only_.end(), flight.group) != only_.end();
      if (selected && (options_.common.overwrite || !finishedFlight(flight)))
        to_fly.push_back(&flight);
    }
    app::Progress progress(experiment_.name, options_.common.quiet);
    std::size_t done = 0;
    return flyAll(to_fly, program_, options_.jobs,
                  [&](const PlannedFlight& flight, const FlightRecord& record)
                  {
                    codes_[flight.name] = record.code;
                    progress.show(double(++done) / double(to_fly.size()), flight.name);
                  });
  }

  std::vector<FlownFlight> readAll() const
  {
    const auto shortest = shortestPaths(options_.data, experiment_.general);
    std::vector<FlownFlight> flights;
    for (const PlannedFlight& planned : plan_)
    {
      const auto record = finishedFlight(planned);
      if (!record)
      {
        flights.push_back({planned, false, unflown(planned), {}, {}});
        continue;
      }
      const auto known = shortest.find(planned.world);
      flights.push_back(
          readFlight(planned, *record, wordsOf(experiment_.find(planned.group)->expect),
                     known == shortest.end() ? std::nullopt : std::optional(known->second)));
    }
    return flights;
  }

  std::string unflown(const PlannedFlight& planned) const
  {
    const auto code = codes_.find(planned.name);
    if (code == codes_.end()) return "not flown";
    if (code->second == app::kInterrupted) return "interrupted";
    return "did not fly: exit code " + std::to_string(code->second) + ", see log.txt";
  }

  int conclude(bool complete) const
  {
    const auto flights = readAll();
    const auto verdicts = judge(experiment_.limits, flights);
    const Results results{experiment_, flights, verdicts, commandOf(options_)};
    report::writeFileAtomically(out_ / "table.csv", tableCsv(results));
    report::writeFileAtomically(out_ / "table.md", tableMarkdown(results, out_));
    report::writeFileAtomically(out_ / "comparison.md", comparisonMarkdown(results));
    for (const Verdict& v : verdicts)
      std::cout << toString(v.judgement) << ": "
                << (v.limit.text.empty() ? v.limit.name : v.limit.text) << " (" << v.limit.must
                << ", is " << (v.value ? std::to_string(*v.value) : std::string("unknown")) << ", "
                << v.measured << " of " << v.planned << " flights)\n";
    std::cout << summaryLine(results) << "; " << (out_ / "table.md").string() << "\n";
    if (!complete) return app::kInterrupted;
    return allMet(verdicts) && experiment_.missing.empty() ? app::kDone : app::kGoalNotReached;
  }

  const Options& options_;
  const Experiment experiment_;
  const fs::path out_, program_;
  std::vector<std::string> only_;
  std::vector<PlannedFlight> plan_;
  std::map<std::string, int> codes_;  // of this run
};
}  // namespace

int run(const Options& options)
{
  return Campaign(options).run();
}

}  // namespace slalom::experiment
