// SPDX-License-Identifier: BSD-3-Clause
/** slalom-experiment: what its INI files may say, how figures become verdicts and tables, and a
 * small experiment flown, interrupted and taken up again. */
#include "Experiment.h"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <nlohmann/json.hpp>
#include <numbers>
#include <string>

#include "Figures.h"
#include "FlightPlan.h"
#include "FlightPool.h"
#include "FlySettings.h"
#include "Program.h"
#include "Tables.h"
#include "Verdict.h"
#include "slalom/core/Rng.h"

namespace slalom::experiment
{
namespace
{
namespace fs = std::filesystem;

const std::string kBin = SLALOM_BIN_DIR;
const fs::path kShipped = SLALOM_CONFIG_DIR "/experiments";

void spill(const fs::path& file, const std::string& content)
{
  fs::create_directories(file.parent_path());
  std::ofstream(file, std::ios::binary) << content;
}

std::string slurp(const fs::path& file)
{
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

struct Result
{
  int code = -1;
  std::string output;
};

Result call(const std::string& command)
{
  Result result;
  FILE* pipe = popen(("exec 2>&1; " + command).c_str(), "r");
  char block[4096];
  while (const std::size_t n = std::fread(block, 1, sizeof block, pipe))
    result.output.append(block, n);
  const int status = pclose(pipe);
  result.code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  return result;
}

constexpr const char* kSmall = R"([experiment]
title = small
settings = report.picture_interval_s=0 state.source=truth
[group.a]
worlds = world.ini
start = 0,0,1.5
goal = 3,0,1.5
time_limit_s = 30
[group.b]
worlds = world.ini
start = 0,3,1.5
goal = 3,3,1.5
time_limit_s = 30
[limit.reached]
metric = success
statistic = sum
must = >= 2
)";

class ExperimentTest : public testing::Test
{
 protected:
  void SetUp() override
  {
    const auto* info = testing::UnitTest::GetInstance()->current_test_info();
    folder_ = fs::temp_directory_path() /
              ("slalom_experiment_" + std::to_string(getpid()) + info->name());
    // A hall: its walls answer every ray.
    spill(folder_ / "world.ini",
          "[world]\nground = true\n[box.w]\nmin = -4,-6,0\nmax = -3.5,8,5\n"
          "[box.e]\nmin = 9,-6,0\nmax = 9.5,8,5\n[box.s]\nmin = -4,-6.5,0\nmax = 9.5,-6,5\n"
          "[box.n]\nmin = -4,8,0\nmax = 9.5,8.5,5\n");
  }
  void TearDown() override { fs::remove_all(folder_); }

  fs::path ini(const std::string& text)
  {
    spill(folder_ / "small.ini", text);
    return folder_ / "small.ini";
  }
  std::string complaint(const std::string& text, const std::vector<std::string>& set = {})
  {
    try
    {
      (void)readExperiment(ini(text), {}, set);
    }
    catch (const mrpt_io::ConfigError& error)
    {
      return error.what();
    }
    return "nothing";
  }
  std::vector<PlannedFlight> plan(const Experiment& experiment) const
  {
    return planFlights(experiment, folder_ / "out", {}, kBin + "/slalom-fly");
  }

  fs::path folder_;
};

bool has(const std::string& text, const std::string& part)
{
  return text.find(part) != std::string::npos;
}

TEST_F(ExperimentTest, MistakesInTheFileAreNamed)
{
  EXPECT_EQ(complaint(kSmall), "nothing");
  const std::string small = kSmall;
  EXPECT_TRUE(has(complaint(small + "[group.c]\nworld = x.csv\n"), "worlds")) << "did you mean";
  EXPECT_TRUE(has(complaint(small + "[grp.c]\nworlds = x.csv\n"), "grp.c"));
  EXPECT_TRUE(has(complaint(small + "[group.c]\nworlds = world.csv\n"), "[group.c] goal"));
  EXPECT_TRUE(has(complaint(kSmall, {"limit.reached.metric=speed"}), "no such figure"));
  EXPECT_TRUE(has(complaint(kSmall, {"limit.reached.groups=c"}), "[group.c]"));
  EXPECT_TRUE(has(complaint(kSmall, {"limit.reached.must=< 2"}), "must"));
  EXPECT_TRUE(has(complaint(kSmall, {"limit.reached.statistic=median"}), "statistic"));
  EXPECT_TRUE(has(complaint(kSmall, {"experiment.columns=success hight"}), "hight"));
  EXPECT_TRUE(has(complaint(kSmall, {"group.a.seeds=5-1"}), "seeds"));
  EXPECT_TRUE(has(complaint(kSmall, {"group.a.seeds=one"}), "seeds"));
  EXPECT_TRUE(has(complaint(kSmall, {"group.a.expect=GOAL"}), "no such result"));
  EXPECT_TRUE(has(complaint(kSmall, {"group.a.settings=vehicle"}), "section.key=value"));
  EXPECT_TRUE(has(complaint(kSmall, {"group.a.time_limit_s=-1"}), "time_limit_s"));
  EXPECT_TRUE(has(complaint("[experiment]\n"), "[group.NAME]"));
  EXPECT_THROW((void)plan(readExperiment(ini(kSmall), {}, {"group.a.worlds=none.csv"})),
               mrpt_io::ConfigError);
  EXPECT_THROW((void)plan(readExperiment(ini(kSmall), {}, {"group.a.worlds=forest:1"})),
               mrpt_io::ConfigError);
}

TEST_F(ExperimentTest, EveryCombinationIsPlannedOnceAndItsKeyTellsWhatIsFlown)
{
  const auto changed = [&](const std::string& set) {
    return plan(readExperiment(ini(kSmall), {}, {"group.a.seeds=1-3", set}));
  };
  const auto base = changed("group.a.note=x");
  ASSERT_EQ(base.size(), 4u);  // three seeds of a, one of b
  EXPECT_EQ(base[1].name, "a/world-s2");
  EXPECT_NE(base[0].key, base[1].key);
  EXPECT_EQ(base[0].key, changed("group.a.note=y")[0].key) << "a remark changes no flight";
  EXPECT_NE(base[0].key, changed("group.a.goal=4,0,1.5")[0].key);
  EXPECT_NE(base[0].key, changed("experiment.settings=state.source=truth")[0].key);
  spill(folder_ / "all.ini", "[vehicle]\nradius_m = 0.3\n");
  spill(folder_ / "own.ini", "[vehicle]\nradius_m = 0.2\n");
  const auto configured = plan(
      readExperiment(ini(kSmall), {}, {"experiment.configs=all.ini", "group.a.configs=own.ini"}));
  const std::vector<std::string> order(configured[0].arguments.begin(),
                                       configured[0].arguments.begin() + 4);
  EXPECT_EQ(order, (std::vector<std::string>{"-c", (folder_ / "all.ini").string(), "-c",
                                             (folder_ / "own.ini").string()}))
      << "a group's own come after those of all";
  spill(folder_ / "world.ini", "[box.a]\nmin = 5,5,0\nmax = 6,6,1\n");
  EXPECT_NE(base[0].key, changed("group.a.note=x")[0].key) << "another world of the same name";
}

/// What slalom-fly would be told must be something that it accepts.
TEST_F(ExperimentTest, ShippedExperimentsArePlannedWithSettingsThatLoad)
{
  const std::map<std::string, std::size_t> flights{{"e1", 20},  {"e2", 6},       {"e3", 4},
                                                   {"e4", 144}, {"gallery", 43}, {"soak", 1}};
  for (const auto& [name, count] : flights)
  {
    SCOPED_TRACE(name);
    const Experiment experiment = readExperiment(experimentFile(name));
    EXPECT_FALSE(experiment.limits.empty());
    EXPECT_TRUE(experiment.missing.empty());
    const auto planned = plan(experiment);
    EXPECT_EQ(planned.size(), count);
    std::string group;
    for (const PlannedFlight& flight : planned)
    {
      if (flight.group == group) continue;
      group = flight.group;
      SCOPED_TRACE(group);
      app::CommonOptions common;
      for (std::size_t i = 0; i + 1 < flight.arguments.size(); ++i)
      {
        if (flight.arguments[i] == "-c") common.configs.push_back(flight.arguments[i + 1]);
        if (flight.arguments[i] == "--set") common.assignments.push_back(flight.arguments[i + 1]);
      }
      EXPECT_NO_THROW((void)app::readFlySettings(common.document()));
    }
  }
}

/// A flight more or less must not pass unnoticed: no limit counts flights that go well, but for
/// those that compare with published counts (e4).
TEST_F(ExperimentTest, EveryFlightOfAShippedExperimentIsJudged)
{
  for (const std::string name : {"e1", "e2", "e3", "gallery", "soak"})
  {
    SCOPED_TRACE(name);
    const Experiment experiment = readExperiment(experimentFile(name));
    // Flights that all did well but for one, each in turn.
    const auto planned = planFlights(experiment, folder_ / "out", {}, folder_ / "world.ini");
    for (std::size_t bad = 0; bad < planned.size(); ++bad)
    {
      SCOPED_TRACE(planned[bad].name);
      std::vector<FlownFlight> flights;
      for (const PlannedFlight& p : planned)
        flights.push_back({p, true, "", "", {{"success", 1}, {"expected", 1}, {"contacts", 0}}});
      flights[bad].figures = {{"success", 0}, {"expected", 0}, {"contacts", 1}};
      const auto verdicts = judge(experiment.limits, flights);
      EXPECT_TRUE(std::any_of(verdicts.begin(), verdicts.end(),
                              [](const Verdict& v) { return v.judgement == Judgement::NotMet; }));
    }
  }
}

/// What [vehicle] says of the airframe, against the airframe: rms of the velocity's difference.
double misfit(const core::Vehicle& believed, const simulation::AirframeConfig& airframe)
{
  constexpr double kTick = 0.05, kInner = 0.005;
  constexpr int kTicks = 2000;
  const auto vehicle = simulation::makeVehicle(airframe, {0.0, 0.0, 10.0}, 0.0, 1);
  core::Rng rng(3);
  Eigen::Vector3d target = Eigen::Vector3d::Zero(), v = target;
  std::vector<Eigen::Vector3d> commands{target};
  double squares = 0.0;
  for (int k = 0; k < kTicks; ++k)
  {
    if (k % 24 == 0)
      target = {rng.uniform(-0.6, 0.6), rng.uniform(-0.6, 0.6), rng.uniform(-0.3, 0.3)};
    // Commands that change by 1 m/s^2 at most, as a planner's do.
    commands.push_back(commands.back() +
                       (target - commands.back()).cwiseMax(-kTick).cwiseMin(kTick));
    vehicle->command({commands.back(), 0.0});
    vehicle->advance(kTick);
    for (int i = 0; i < 10; ++i)
    {
      const double t = k + ((i + 0.5) * kInner - believed.command_delay_s) / kTick;
      const auto obeyed = static_cast<std::size_t>(std::max(0.0, std::floor(t) + 1.0));
      v += (commands[obeyed] - v) * (1.0 - std::exp(-kInner / believed.velocity_lag_s));
    }
    squares += (v - vehicle->sample().v_W).squaredNorm();
  }
  return std::sqrt(squares / kTicks);
}

TEST(Vehicles, QuadrotorIsWhatItsFileSaysOfIt)
{
  app::CommonOptions common;
  common.configs = {SLALOM_CONFIG_DIR "/vehicles/quadrotor.ini"};
  const app::FlySettings settings = app::readFlySettings(common.document());
  EXPECT_EQ(settings.airframe.model, simulation::AirframeModel::Quadrotor);
  const double best = misfit(settings.engine.vehicle, settings.airframe);
  EXPECT_LT(best, 0.01);
  for (const double change : {-0.03, 0.03})
  {
    core::Vehicle other = settings.engine.vehicle;
    other.velocity_lag_s += change;
    EXPECT_GT(misfit(other, settings.airframe), best) << change;
    other = settings.engine.vehicle;
    other.command_delay_s += change;
    EXPECT_GT(misfit(other, settings.airframe), best) << change;
  }
}

TEST_F(ExperimentTest, SameSeedMakesTheSameForest)
{
  const std::string set = "group.a.worlds=forest:7:0.1 forest:8:0.1";
  const auto first = plan(readExperiment(ini(kSmall), {}, {set}));
  const auto again = plan(readExperiment(ini(kSmall), {}, {set}));
  ASSERT_EQ(first.size(), 3u);
  EXPECT_EQ(first[0].key, again[0].key);
  EXPECT_NE(slurp(folder_ / "out/worlds/forest_7_100.csv"),
            slurp(folder_ / "out/worlds/forest_8_100.csv"));
}

/// A point that runs round a circle of radius 5 with another one beside it, `off` to the outside
/// and `late` seconds behind.
struct Circle
{
  double off, late;
  [[nodiscard]] Path path(double dt) const
  {
    Path path;
    for (double t = 0.0; t < 30.0; t += dt)
    {
      const double a = 2.0 * std::numbers::pi * (t - late) / 30.0;
      path.t.push_back(t);
      path.points.emplace_back((5.0 + off) * std::cos(a), (5.0 + off) * std::sin(a), 2.0);
    }
    return path;
  }
};

TEST(Errors, ToTheLineIgnoreWhatIsLateAndToThePointDoNot)
{
  const Path reference = Circle{0.0, 0.0}.path(0.05);
  const Path flown = Circle{0.1, 0.5}.path(0.02);
  const auto to_line = errorFigures(distancesToLine(flown, reference, 3.0));
  ASSERT_TRUE(to_line);
  // The first half second lies before the line's beginning.
  EXPECT_NEAR(to_line->mean, 0.1, 0.005);
  EXPECT_NEAR(to_line->p95, 0.1, 0.001);
  const auto to_point = errorFigures(distancesInTime(flown, reference));
  ASSERT_TRUE(to_point);
  EXPECT_NEAR(to_point->mean, 0.5 * 5.05 * 2.0 * std::numbers::pi / 30.0, 0.02);
}

TEST(Errors, TheOtherBranchOfACrossingIsNoExcuse)
{
  // There and back along x, 1 m apart in y; the vehicle flies the way there on the way back's line.
  Path reference, flown;
  for (int i = 0; i <= 400; ++i)
  {
    const double t = 0.1 * i;
    const bool there = t < 20.0;
    reference.t.push_back(t);
    reference.points.emplace_back(there ? t : 40.0 - t, there ? 0.0 : 1.0, 0.0);
    flown.t.push_back(t);
    flown.points.emplace_back(there ? t : 40.0 - t, 1.0, 0.0);
  }
  const auto e = errorFigures(distancesToLine(flown, reference, 3.0));
  ASSERT_TRUE(e);
  EXPECT_NEAR(e->max, 1.0, 1e-9);
  EXPECT_FALSE(errorFigures({}));
  EXPECT_NEAR(errorFigures({4.0, 1.0, 2.0, 3.0})->p95, 4.0, 0.0);
}

FlownFlight flownIn(const std::string& group, std::map<std::string, double> figures)
{
  FlownFlight flight;
  flight.planned.group = group;
  flight.planned.name = group + "/w-s1";
  flight.flown = true;
  flight.result = "GOAL_REACHED";
  flight.figures = std::move(figures);
  return flight;
}

Judgement judgementOf(const std::vector<FlownFlight>& flights, const std::string& statistic,
                      const std::string& must, bool successes_only = false,
                      const std::string& relative_to = {})
{
  Limit limit;
  limit.groups = "a";
  limit.metric = "length_m";
  limit.statistic = statistic;
  limit.must = must;
  limit.successes_only = successes_only;
  limit.relative_to = relative_to;
  return judge({limit}, flights).at(0).judgement;
}

TEST(Verdicts, FollowTheFigures)
{
  const std::vector<FlownFlight> flights{flownIn("a", {{"length_m", 10}, {"success", 1}}),
                                         flownIn("a", {{"length_m", 30}, {"success", 0}}),
                                         flownIn("b", {{"length_m", 99}, {"success", 1}})};
  EXPECT_EQ(judgementOf(flights, "mean", "<= 20"), Judgement::Met);
  EXPECT_EQ(judgementOf(flights, "mean", "<= 19.9"), Judgement::NotMet);
  EXPECT_EQ(judgementOf(flights, "max", "== 30"), Judgement::Met);
  EXPECT_EQ(judgementOf(flights, "min", ">= 10.1"), Judgement::NotMet);
  EXPECT_EQ(judgementOf(flights, "sum", ">= 40"), Judgement::Met);
  EXPECT_EQ(judgementOf(flights, "max", "<= 10", true), Judgement::Met);
  EXPECT_EQ(judgementOf(flights, "mean", "<= 0.21", false, "b"), Judgement::Met);
  EXPECT_EQ(judgementOf(flights, "mean", "<= 0.2", false, "b"), Judgement::NotMet);
  EXPECT_EQ(judgementOf(flights, "mean", "<= 9", false, "none"), Judgement::NotMeasured);
}

TEST(Verdicts, WhatIsNotMeasuredIsNeverMet)
{
  std::vector<FlownFlight> flights{flownIn("a", {{"length_m", 10}}), flownIn("a", {})};
  EXPECT_EQ(judgementOf(flights, "mean", "<= 20"), Judgement::NotMeasured);
  EXPECT_EQ(judgementOf(flights, "max", "<= 20"), Judgement::NotMeasured);
  EXPECT_EQ(judgementOf(flights, "max", "<= 9"), Judgement::NotMet) << "that is broken already";
  EXPECT_EQ(judgementOf({}, "sum", ">= 0"), Judgement::NotMeasured);
  flights[1].flown = false;
  EXPECT_EQ(judgementOf(flights, "max", "<= 20", true), Judgement::NotMeasured);
  EXPECT_FALSE(allMet({}));
}

constexpr const char* kMetrics = R"({"result": {"code": 0, "name": "GOAL_REACHED", "message": ""},
"success": true, "goal_error_m": 0.2, "reference_length_m": 20.0,
"timing": {"map": {"n": 10, "mean_ms": 2.0}, "edt": {"n": 10, "mean_ms": 1.5},
           "global": {"n": 10, "mean_ms": 1.0, "p99_ms": null}, "local": {"n": 20, "mean_ms": 0.5},
           "deadline_misses": {"map": 1, "global": 0, "local": 1}},
"flight": {"length_m": 22.0, "contacts": 0, "duration_s": 20.0, "min_clearance_m": null},
"run": {"realtime_factor": 10.0}})";

TEST_F(ExperimentTest, FiguresComeFromTheFilesOfAFlight)
{
  PlannedFlight planned = plan(readExperiment(ini(kSmall))).at(0);
  spill(planned.folder / "metrics.json", kMetrics);
  std::string timing = "t,cycle_ms\n", memory = "t_s,rss_mb\n";
  for (int i = 0; i < 16; ++i)
  {
    timing += std::to_string(i) + "," + (i < 12 ? "2" : "3") + "\n";
    memory += std::to_string(i) + "," + std::to_string(i < 4 ? 10 : 40 + (i >= 12 ? 2 : 0)) + "\n";
  }
  spill(planned.folder / "timing.csv", timing);
  spill(planned.folder / "memory.csv", memory);
  const FlightRecord record{planned.key, 0, 2.5};
  const FlownFlight flight = readFlight(planned, record, {"GOAL_REACHED"}, 20.0);
  const std::map<std::string, double> wanted{
      {"success", 1},      {"expected", 1},       {"ratio", 1.1},        {"detour", 1.1},
      {"mapping_ms", 3.5}, {"misses", 2},         {"miss_share", 0.05},  {"cycle_ratio", 1.5},
      {"wall_s", 2.5},     {"memory_max_mb", 42}, {"memory_ratio", 1.05}};
  for (const auto& [name, value] : wanted)
  {
    ASSERT_TRUE(flight.figure(name)) << name;
    EXPECT_NEAR(*flight.figure(name), value, 1e-9) << name;
  }
  for (const char* unknown : {"clearance_m", "planning_p99_ms", "r_mean_m"})
    EXPECT_FALSE(flight.figure(unknown)) << unknown;
  EXPECT_NEAR(*readFlight(planned, record, {"GOAL_BLOCKED"}, {}).figure("expected"), 0, 0);
  EXPECT_FALSE(readFlight(planned, record, {}, {}).figure("ratio"));
}

TEST_F(ExperimentTest, AContactIsNeverWhatWasExpected)
{
  PlannedFlight planned = plan(readExperiment(ini(kSmall))).at(0);
  std::string metrics = kMetrics;
  metrics.replace(metrics.find("\"contacts\": 0"), 13, "\"contacts\": 2");
  spill(planned.folder / "metrics.json", metrics);
  const FlownFlight flight = readFlight(planned, {}, {"GOAL_REACHED"}, 20.0);
  EXPECT_EQ(flight.figure("success"), 0.0);
  EXPECT_FALSE(flight.figure("ratio")) << "of a flight that did not succeed";
  EXPECT_EQ(flight.figure("expected"), 0.0);
  spill(planned.folder / "metrics.json", "{\"result\": ");
  EXPECT_THROW((void)readFlight(planned, {}, {}, {}), std::runtime_error);
}

TEST_F(ExperimentTest, OnlyAFlightThatEndedByItselfWithTheseSettingsIsFinished)
{
  PlannedFlight planned = plan(readExperiment(ini(kSmall))).at(0);
  const auto record = [&](const std::string& key, int code)
  {
    spill(planned.folder / "flight.json",
          nlohmann::json{{"key", key}, {"code", code}, {"wall_s", 1.0}}.dump());
  };
  EXPECT_FALSE(finishedFlight(planned));
  record(planned.key, 0);
  EXPECT_FALSE(finishedFlight(planned)) << "no metrics.json";
  spill(planned.folder / "metrics.json", kMetrics);
  EXPECT_TRUE(finishedFlight(planned));
  for (const int code : {4, 5, 6})
  {
    record(planned.key, code);
    EXPECT_TRUE(finishedFlight(planned)) << code;
  }
  for (const int code : {1, 2, 3, 130, 137})
  {
    record(planned.key, code);
    EXPECT_FALSE(finishedFlight(planned)) << code;
  }
  record("other", 0);
  EXPECT_FALSE(finishedFlight(planned));
  spill(planned.folder / "flight.json", "{\"key\": ");
  EXPECT_FALSE(finishedFlight(planned));
}

TEST_F(ExperimentTest, TablesHoldEveryFlightAndSayWhatIsMissing)
{
  const Experiment experiment =
      readExperiment(ini(std::string(kSmall) + "[missing.door]\ntext = cannot be flown\n"));
  FlownFlight other = flownIn("b", {});
  other.flown = false;
  other.result = "not flown";
  const std::vector<FlownFlight> flights{flownIn("a", {{"success", 1}, {"length_m", 12.3456}}),
                                         other};
  const auto verdicts = judge(experiment.limits, flights);
  const Results results{experiment, flights, verdicts, "slalom-experiment small.ini"};
  const std::string csv = tableCsv(results);
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 3);
  EXPECT_TRUE(has(csv, "12.3456"));
  const std::string md = tableMarkdown(results, folder_);
  for (const char* part : {"not measured", "1 of 2", "not flown", "door: cannot be flown", "12.35"})
    EXPECT_TRUE(has(md, part)) << part << "\n" << md;
  EXPECT_TRUE(has(summaryLine(results), "0 of 1 acceptance numbers met, 1 flights missing"));
}

/// The whole program on two flights of some seconds.
TEST_F(ExperimentTest, IsFlownTakenUpAgainAndNotFlownTwice)
{
  const std::string command =
      kBin + "/slalom-experiment -q -o " + (folder_ / "out").string() + " " + ini(kSmall).string();
  const fs::path a = folder_ / "out/flights/a/world-s1/flight.json";
  const fs::path b = folder_ / "out/flights/b/world-s1/flight.json";

  const Result half = call(command + " --only a");
  EXPECT_EQ(half.code, 4) << half.output;
  EXPECT_TRUE(has(half.output, "not measured")) << half.output;
  ASSERT_TRUE(fs::exists(a)) << half.output;
  EXPECT_FALSE(fs::exists(b));
  const std::string first = slurp(a);

  const Result whole = call(command);
  EXPECT_EQ(whole.code, 0) << whole.output << slurp(folder_ / "out/table.md");
  EXPECT_EQ(slurp(a), first) << "flown again";
  ASSERT_TRUE(fs::exists(b));
  for (const char* file :
       {"table.md", "table.csv", "comparison.md", "effective.ini", "flights/a/world-s1/log.txt",
        "flights/a/world-s1/memory.csv", "flights/a/world-s1/overview.png"})
    EXPECT_TRUE(fs::exists(folder_ / "out" / file)) << file;
  EXPECT_TRUE(has(slurp(folder_ / "out/table.md"), "GOAL_REACHED"));

  const Result strict = call(command + " --set 'limit.reached.must=>= 3'");
  EXPECT_EQ(strict.code, 4) << strict.output;
  EXPECT_EQ(slurp(a), first);
}

TEST_F(ExperimentTest, InterruptedFinishesItsTablesAndGoesOnLater)
{
  // A flight that takes long: it is interrupted as soon as its log is there.
  const std::string out = (folder_ / "out").string();
  const std::string command = kBin + "/slalom-experiment -q -o " + out + " " +
                              ini(kSmall).string() +
                              " --set group.a.goal=6,-2,1.5 --set group.a.settings=fly.settle_s=60 "
                              "--set group.a.worlds=world.ini" +
                              " --set group.a.time_limit_s=20000";
  const Result cut =
      call(command + " & child=$!; until test -s " + out +
           "/flights/a/world-s1/events.csv.part -o -s " + out +
           "/flights/a/world-s1/cycles.csv.part; do kill -0 $child || break; done; kill -INT "
           "$child; wait $child; echo code $?");
  EXPECT_TRUE(has(cut.output, "code 130")) << cut.output;
  const fs::path table = folder_ / "out/table.md";
  ASSERT_TRUE(fs::exists(table)) << cut.output;
  EXPECT_TRUE(has(slurp(table), "interrupted")) << slurp(table);
  EXPECT_FALSE(fs::exists(folder_ / "out/flights/b/world-s1")) << "begun after the interrupt";
  EXPECT_EQ(call(kBin + "/slalom-experiment -q -o " + out + " " + ini(kSmall).string()).code, 0);
}

TEST_F(ExperimentTest, UsageIsAnsweredSensibly)
{
  const std::string program = kBin + "/slalom-experiment ";
  EXPECT_EQ(call(program + "--help").code, 0);
  EXPECT_EQ(call(program).code, 2);
  EXPECT_EQ(call(program + "e9 -o " + (folder_ / "o").string()).code, 2);
  EXPECT_EQ(call(program + "e1").code, 2);
  EXPECT_EQ(call(program + "e1 -o /dev/null").code, 2);
  EXPECT_EQ(call(program + "e1 --jobs 0 -o x").code, 2);
  EXPECT_EQ(call(program + "e1 --only none -o " + (folder_ / "o").string()).code, 2);
  EXPECT_EQ(call(program + "e4 --data /nowhere -o " + (folder_ / "o").string()).code, 2);
}

}  // namespace
}  // namespace slalom::experiment
