// SPDX-License-Identifier: BSD-3-Clause
#include "FlightPlan.h"

#include <cstdio>
#include <map>
#include <optional>
#include <set>

#include "Sha256.h"
#include "slalom/core/TextTable.h"
#include "slalom/report/AtomicFile.h"
#include "slalom/simulation/Forest.h"
#include "slalom/spline/WaypointFile.h"

namespace slalom::experiment
{
namespace
{
namespace fs = std::filesystem;
using mrpt_io::ConfigError;

class Planner
{
 public:
  Planner(const Experiment& experiment, fs::path out, fs::path data, const fs::path& program)
      : experiment_(experiment), out_(std::move(out)), data_(std::move(data))
  {
    // The engine is in the plugin, not in the program.
    build_ = digestOf(program);
    const fs::path plugin = program.parent_path().parent_path() / "lib/slalom-tracker.so";
    const fs::path library = program.parent_path().parent_path() / "lib/libslalom_navigator.so";
    for (const fs::path& part : {plugin, library})
      if (fs::exists(part)) build_ += digestOf(part);
  }

  std::vector<PlannedFlight> plan()
  {
    for (const Group& group : experiment_.groups) planGroup(group);
    return std::move(flights_);
  }

 private:
  struct Mission
  {
    fs::path waypoints;  // may be empty
    std::string start, goal;
  };

  void planGroup(const Group& group);
  void add(const Group& group, const fs::path& world, const Mission& mission, std::uint64_t seed);
  std::vector<fs::path> worldsOf(const Group& group);
  std::vector<Mission> missionsOf(const Group& group);
  fs::path forestOf(const Group& group, const std::string& word);
  fs::path existing(const Group& group, const fs::path& folder, const std::string& name) const;
  std::string keyOf(const std::vector<std::string>& arguments);
  const std::string& digestOf(const fs::path& file);

  const Experiment& experiment_;
  fs::path out_, data_;
  std::string build_;
  std::map<fs::path, std::string> digests_;
  std::set<std::string> names_;
  std::vector<PlannedFlight> flights_;
};

const std::string& Planner::digestOf(const fs::path& file)
{
  auto [digest, is_new] = digests_.try_emplace(file);
  if (is_new) digest->second = app::sha256OfFile(file);
  return digest->second;
}

fs::path Planner::existing(const Group& group, const fs::path& folder,
                           const std::string& name) const
{
  const fs::path file = (folder / name).lexically_normal();
  if (!fs::is_regular_file(file))
    throw ConfigError("[group." + group.name + "]: there is no file " + file.string());
  return file;
}

/// forest:SEED:DENSITY becomes a csv.
fs::path Planner::forestOf(const Group& group, const std::string& word)
{
  const auto wrong = [&]
  {
    return ConfigError("[group." + group.name + "] worlds = " + word +
                       ": forest:SEED:DENSITY[:SIZE] is needed");
  };
  std::vector<double> numbers;
  for (std::size_t begin = word.find(':'); begin != std::string::npos;)
  {
    const std::size_t end = word.find(':', begin + 1);
    const auto number =
        core::parseNumber(word.substr(begin + 1, end == std::string::npos ? end : end - begin - 1));
    if (!number || *number < 0.0) throw wrong();
    numbers.push_back(*number);
    begin = end;
  }
  if (numbers.size() < 2 || numbers.size() > 3 || numbers[0] > 1e15) throw wrong();
  simulation::ForestConfig forest;
  forest.density_per_m2 = numbers[1];
  if (numbers.size() == 3) forest.size_m = numbers[2];
  const auto seed = static_cast<std::uint64_t>(numbers[0]);
  char name[80];
  std::snprintf(name, sizeof name, "forest_%llu_%03.0f", static_cast<unsigned long long>(seed),
                1000.0 * forest.density_per_m2);
  const fs::path file = out_ / "worlds" / (std::string(name) + ".csv");
  try
  {
    fs::create_directories(file.parent_path());
    report::writeFileAtomically(file, simulation::forestCsv(simulation::makeForest(forest, seed)));
  }
  catch (const std::invalid_argument& error)
  {
    throw ConfigError("[group." + group.name + "] worlds = " + word + ": " + error.what());
  }
  return file;
}

std::vector<fs::path> Planner::worldsOf(const Group& group)
{
  std::vector<fs::path> worlds;
  const bool shipped = data_.empty() || wordsOf(group.data_worlds).empty();
  for (const std::string& word : wordsOf(shipped ? group.worlds : group.data_worlds))
    worlds.push_back(word.starts_with("forest:")
                         ? forestOf(group, word)
                         : existing(group, shipped ? experiment_.folder : data_, word));
  return worlds;
}

std::vector<Planner::Mission> Planner::missionsOf(const Group& group)
{
  std::vector<Mission> missions;
  for (const std::string& word : wordsOf(group.waypoints))
  {
    Mission mission{existing(group, experiment_.folder, word), group.start, group.goal};
    if (mission.start.empty())
    {
      try
      {
        const Eigen::Vector3d p = spline::readWaypoints(mission.waypoints).points_W.col(0);
        char text[120];
        std::snprintf(text, sizeof text, "%.4f,%.4f,%.4f", p.x(), p.y(), p.z());
        mission.start = text;
      }
      catch (const std::runtime_error& error)
      {
        throw ConfigError(error.what());
      }
    }
    missions.push_back(std::move(mission));
  }
  if (missions.empty()) missions.push_back({{}, group.start, group.goal});
  return missions;
}

std::string Planner::keyOf(const std::vector<std::string>& arguments)
{
  std::string all = build_;
  for (const std::string& argument : arguments)
    all += "\n" + argument + (fs::is_regular_file(argument) ? " " + digestOf(argument) : "");
  return app::sha256OfText(all);
}

void Planner::add(const Group& group, const fs::path& world, const Mission& mission,
                  std::uint64_t seed)
{
  PlannedFlight flight;
  flight.group = group.name;
  flight.world = world.stem().string();
  flight.seed = seed;
  flight.name = group.name + "/" + flight.world;
  auto& arguments = flight.arguments;
  for (const std::string* configs : {&experiment_.general.configs, &group.configs})
    for (const std::string& config : wordsOf(*configs))
      arguments.insert(arguments.end(),
                       {"-c", existing(group, experiment_.folder, config).string()});
  for (const std::string* settings : {&experiment_.general.settings, &group.settings})
    for (const std::string& setting : wordsOf(*settings))
      arguments.insert(arguments.end(), {"--set", setting});
  arguments.insert(arguments.end(), {"--world", world.string(), "--start=" + mission.start});
  if (!mission.waypoints.empty())
  {
    flight.name += "-" + mission.waypoints.stem().string();
    arguments.insert(arguments.end(), {"--waypoints", mission.waypoints.string()});
  }
  if (!mission.goal.empty()) arguments.push_back("--goal=" + mission.goal);
  if (group.time_limit_s > 0.0)
    arguments.insert(arguments.end(), {"--time-limit", std::to_string(group.time_limit_s)});
  arguments.insert(arguments.end(), {"--seed", std::to_string(seed)});
  flight.name += "-s" + std::to_string(seed);
  if (!names_.insert(flight.name).second)
    throw ConfigError("[group." + group.name + "]: two flights would be called " + flight.name);
  flight.folder = out_ / "flights" / flight.name;
  if (experiment_.general.record)
    arguments.insert(arguments.end(), {"--record", (flight.folder / "flight.rawlog").string()});
  flight.key = keyOf(arguments);
  flights_.push_back(std::move(flight));
}

void Planner::planGroup(const Group& group)
{
  const auto missions = missionsOf(group);
  const auto seeds = seedsOf(group.seeds);
  for (const fs::path& world : worldsOf(group))
    for (const Mission& mission : missions)
      for (const std::uint64_t seed : seeds) add(group, world, mission, seed);
}
}  // namespace

std::vector<PlannedFlight> planFlights(const Experiment& experiment, const fs::path& out,
                                       const fs::path& data, const fs::path& program)
{
  return Planner(experiment, out, data, program).plan();
}

}  // namespace slalom::experiment
