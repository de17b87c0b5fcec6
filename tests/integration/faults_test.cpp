// SPDX-License-Identifier: BSD-3-Clause
// The fault matrix: what goes wrong, what the engine is to say of it, and that nothing is hit.
#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <limits>
#include <optional>
#include <set>
#include <sstream>
#include <stdexcept>
#include <thread>

#include "FlightHarness.h"
#include "slalom/local_planner/LocalPlanner.h"

namespace slalom
{
namespace
{
using engine::EngineStatus;
using test::FlightHarness;

constexpr double kLength = 12.0;
constexpr double kBegin_s = 5.0;  // of the fault; the vehicle is in mid-forest then
const Eigen::Vector3d kStart(0.0, 0.0, 1.5);

/// Everything a fault may take hold of.
struct Scene
{
  test::AnalyticField forest = test::flightForest(4, 0.12, kLength);
  std::optional<Eigen::AlignedBox3d> wall;  // may appear
  engine::EngineConfig config = test::flightConfig();
  engine::StepHooks hooks;
  test::FaultInjector faults;
  engine::Mission mission{Eigen::Vector3d(kLength, 0.0, 1.5)};
  bool fusion = false;
  double command_delay_s = 0.0;
  int cycle_steps = 5;  // hundredths of a second
  double time_limit_s = 30.0;

  std::atomic<double> t{0.0};  // flight time; workers look at it
  std::atomic<bool> over{false};
  Eigen::Vector3d p_W = kStart, v_W = Eigen::Vector3d::Zero();  // the vehicle, at the last cycle

  [[nodiscard]] double distance(const Eigen::Vector3d& p) const
  {
    const double trees = forest.signedDistance(p);
    return wall ? std::min(trees, test::Obstacle(*wall).distance(p)) : trees;
  }
  [[nodiscard]] bool now(double seconds) const { return t >= kBegin_s && t < kBegin_s + seconds; }
};

constexpr double kForEver = std::numeric_limits<double>::infinity();

/// A row of the matrix.
struct Fault
{
  std::string name, when;
  std::function<void(Scene&)> arrange;
  std::vector<std::string> events;  ///< that have to be told, in this order
  std::set<EngineStatus> ends;      ///< allowed at the end
  double rest_s = kForEver;         ///< after its begin the vehicle has to rest within this
  double least_clearance_m = core::Vehicle{}.radius_m;
};

/// Changes the measurements of one kind while the fault lasts; `change` says false for a lost one.
template <class Kind, class Change>
void onSensor(Scene& scene, double seconds, Change change)
{
  scene.faults.sensor = [&scene, seconds, change](core::Measurement& measurement)
  {
    auto* mine = std::get_if<Kind>(&measurement);
    return !mine || !scene.now(seconds) || change(*mine);
  };
}

void loseAllBut(Scene& scene, double seconds, bool scans)
{
  scene.faults.sensor = [&scene, seconds, scans](core::Measurement& measurement)
  { return !scene.now(seconds) || std::holds_alternative<core::RangeScan>(measurement) == scans; };
}

/// Keeps a worker busy until flight time has gone on by `seconds`.
void takeTime(const Scene& scene, double seconds)
{
  for (const double end = scene.t + seconds; scene.t < end && !scene.over;)
    std::this_thread::yield();
}

void failSolver(Scene& scene, double seconds)
{
  scene.hooks.local = [&scene, seconds](local_planner::LocalPlannerInput& input)
  {
    if (scene.now(seconds)) input.deadline = core::Deadline::in({});
  };
}

/// Something that is not even a std::exception.
std::function<void()> throwingANumber(const Scene& scene, double seconds)
{
  return [&scene, seconds]
  {
    if (scene.now(seconds)) throw 42;
  };
}

std::function<void()> throwing(const Scene& scene, double seconds)
{
  return [&scene, seconds]
  {
    if (scene.now(seconds)) throw std::runtime_error("out of memory");
  };
}

void wallAhead(Scene& scene, double distance)
{
  scene.faults.world = [&scene, distance](double t, const Eigen::Vector3d& p)
  {
    if (t < kBegin_s || scene.wall) return;
    scene.wall = Eigen::AlignedBox3d(p + Eigen::Vector3d(distance, -1.5, -3.0),
                                     p + Eigen::Vector3d(distance + 0.3, 1.5, 3.0));
  };
}

void randomVerbs(Scene& scene, std::uint64_t seed)
{
  scene.time_limit_s = 45.0;
  auto rng = std::make_shared<core::Rng>(seed);
  auto until = std::make_shared<double>(2.0);
  auto verb = std::make_shared<int>(0);
  scene.faults.host = [&scene, rng, until, verb](double t, engine::Engine& engine)
  {
    if (t >= *until && t < 16.0)
    {
      *until = t + rng->uniform(0.1, 2.0);
      *verb = static_cast<int>(rng->uniform(0.0, 3.0));  // fly, suspend, cancel
      if (*verb == 2) engine.clearMission();
      if (*verb == 0 && engine.status() == EngineStatus::NoMission)
        engine.setMission(scene.mission);
    }
    else if (t >= 16.0 && *verb != 0)
    {
      *verb = 0;
      engine.setMission(scene.mission);
    }
    return *verb == 0;
  };
}

void useFusion(Scene& scene)
{
  scene.fusion = true;
  scene.config.state.source = engine::StateSourceKind::Fusion;
}

const std::set<EngineStatus> kArrives{EngineStatus::GoalReached};
const std::set<EngineStatus> kGivesUp{EngineStatus::Navigating, EngineStatus::Unreachable};
const std::set<EngineStatus> kAny{EngineStatus::GoalReached, EngineStatus::Navigating,
                                  EngineStatus::Unreachable, EngineStatus::GoalBlocked};
const std::vector<std::string> kStops{"SAFE_STOP"}, kStopsAndGoesOn{"SAFE_STOP", "RECOVER"};

std::vector<Fault> stateFaults()
{
  return {
      {"none", "-", [](Scene&) {}, {"NAVIGATING", "GOAL_REACHED"}, kArrives},
      {"none, by fused sensors", "-", useFusion, {"GOAL_REACHED"}, kArrives},
      {"GPS jump of 2 m",
       "for ever",
       [](Scene& s)
       {
         useFusion(s);
         onSensor<core::PositionFix>(s, kForEver,
                                     [](core::PositionFix& fix)
                                     {
                                       fix.p_W.y() += 2.0;
                                       return true;
                                     });
       },
       {"GOAL_REACHED"},
       kArrives},
      {"state lost",
       "0.5 s",
       [](Scene& s) { loseAllBut(s, 0.5, true); },
       {"GOAL_REACHED"},
       kArrives},
      {"state lost", "3 s", [](Scene& s) { loseAllBut(s, 3.0, true); }, kStopsAndGoesOn, kArrives,
       2.5},
      {"state frozen", "for ever",
       [](Scene& s)
       {
         auto frozen = std::make_shared<std::optional<Eigen::Isometry3d>>();
         onSensor<core::PoseFix>(s, kForEver,
                                 [frozen](core::PoseFix& fix)
                                 {
                                   if (!*frozen) *frozen = fix.T_WB;
                                   fix.T_WB = **frozen;
                                   return true;
                                 });
       },
       kStops, kGivesUp, 3.0},
      {"pose 3 s ahead of its time", "once",
       [](Scene& s)
       {
         onSensor<core::PoseFix>(s, kForEver,
                                 [told = std::make_shared<bool>(false)](core::PoseFix& fix)
                                 {
                                   if (!std::exchange(*told, true)) fix.t += 3.0;
                                   return true;
                                 });
       },
       kStopsAndGoesOn, kArrives, 2.5},
  };
}

std::vector<Fault> sensorFaults()
{
  return {
      {"scans stop", "3 s", [](Scene& s) { loseAllBut(s, 3.0, false); }, kStopsAndGoesOn, kArrives,
       3.5},
      {"scans stop",
       "for ever",
       [](Scene& s) { loseAllBut(s, kForEver, false); },
       kStops,
       {EngineStatus::Navigating},
       3.5},
      {"scans stop, sensor_timeout_s = 3",
       "for ever",
       [](Scene& s)
       {
         s.config.mission.sensor_timeout_s = 3.0;
         loseAllBut(s, kForEver, false);
       },
       {"SAFE_STOP", "SENSOR_LOST"},
       {EngineStatus::SensorLost},
       3.5},
      {"state lost, sensor_timeout_s = 3",
       "for ever",
       [](Scene& s)
       {
         s.config.mission.sensor_timeout_s = 3.0;
         loseAllBut(s, kForEver, true);
       },
       {"SAFE_STOP", "SENSOR_LOST"},
       {EngineStatus::SensorLost},
       2.5},
      {"scans empty, sensor_timeout_s = 3",
       "for ever",
       [](Scene& s)
       {
         s.config.mission.sensor_timeout_s = 3.0;
         onSensor<core::RangeScan>(s, kForEver,
                                   [](core::RangeScan& scan)
                                   {
                                     scan.points.clear();
                                     return true;
                                   });
       },
       {"SAFE_STOP", "SENSOR_LOST"},
       {EngineStatus::SensorLost},
       3.5},
      {"scans empty",
       "for ever",
       [](Scene& s)
       {
         onSensor<core::RangeScan>(s, kForEver,
                                   [](core::RangeScan& scan)
                                   {
                                     scan.points.clear();
                                     return true;
                                   });
       },
       kStops,
       {EngineStatus::Navigating},
       3.5},
      {"scans NaN",
       "for ever",
       [](Scene& s)
       {
         onSensor<core::RangeScan>(s, kForEver,
                                   [](core::RangeScan& scan)
                                   {
                                     for (auto& point : scan.points)
                                       point.p_S.setConstant(std::nanf(""));
                                     return true;
                                   });
       },
       kStops,
       {EngineStatus::Navigating},
       3.5},
      {"scans mirrored",
       "for ever",
       [](Scene& s)
       {
         s.config.mission.blocked_timeout_s = 3.0;
         onSensor<core::RangeScan>(s, kForEver,
                                   [](core::RangeScan& scan)
                                   {
                                     for (auto& point : scan.points) point.p_S.y() *= -1.0f;
                                     return true;
                                   });
       },
       {"SAFE_STOP", "UNREACHABLE"},
       {EngineStatus::Unreachable},
       3.5},
  };
}

std::vector<Fault> plannerFaults()
{
  return {
      // Without solutions the certified plan is pursued as long as nothing is in the way.
      {"local solver times out",
       "1 s",
       [](Scene& s) { failSolver(s, 1.0); },
       {"GOAL_REACHED"},
       kArrives},
      {"local solver times out", "for ever", [](Scene& s) { failSolver(s, kForEver); }, {}, kAny},
      {"local solver has one iteration",
       "always",
       [](Scene& s) { s.config.local_planner.max_iterations = 1; },
       {},
       kAny},
      {"mapper throws", "2 s", [](Scene& s) { s.hooks.map = throwing(s, 2.0); }, kStopsAndGoesOn,
       kArrives},
      {"global planner throws",
       "2 s",
       [](Scene& s) { s.hooks.global = throwing(s, 2.0); },
       {"GOAL_REACHED"},
       kArrives},
      {"global planner throws", "for ever",
       [](Scene& s) { s.hooks.global = throwing(s, kForEver); }, kStops, kGivesUp, 8.0},
      {"mapper throws a number", "2 s", [](Scene& s) { s.hooks.map = throwingANumber(s, 2.0); },
       kStopsAndGoesOn, kArrives},
      {"mapper and global planner throw numbers, in threads",
       "2 s",
       [](Scene& s)
       {
         s.config.rates.threaded = true;
         s.hooks.map = s.hooks.global = throwingANumber(s, 2.0);
       },
       {"GOAL_REACHED"},
       kArrives},
      {"local planner throws a number", "2 s",
       [](Scene& s)
       {
         s.hooks.local = [fails = throwingANumber(s, 2.0)](local_planner::LocalPlannerInput&)
         { fails(); };
       },
       kStopsAndGoesOn, kArrives, 2.5},
      {"local planner throws", "2 s",
       [](Scene& s) {
         s.hooks.local = [fails = throwing(s, 2.0)](local_planner::LocalPlannerInput&) { fails(); };
       },
       kStopsAndGoesOn, kArrives, 2.5},
      {"global planner late by 0.5 s, in threads",
       "always",
       [](Scene& s)
       {
         s.config.rates.threaded = true;
         s.hooks.global = [&s] { takeTime(s, 0.5); };
       },
       {},
       kAny},
      {"threads starved",
       "always",
       [](Scene& s)
       {
         s.config.rates.threaded = true;
         auto rng = std::make_shared<core::Rng>(5);
         auto other = std::make_shared<core::Rng>(6);
         s.hooks.map = [&s, rng] { takeTime(s, rng->uniform(0.0, 0.4)); };
         s.hooks.global = [&s, other] { takeTime(s, other->uniform(0.0, 0.8)); };
       },
       {},
       kAny},
  };
}

std::vector<Fault> outerFaults()
{
  std::vector<Fault> rows;
  for (const double delay : {0.05, 0.2})
  {
    const std::string name = "latency " + std::to_string(static_cast<int>(1e3 * delay)) + " ms";
    rows.push_back({name + ", known",
                    "always",
                    [delay](Scene& s)
                    { s.command_delay_s = s.config.vehicle.command_delay_s = delay; },
                    {"GOAL_REACHED"},
                    kArrives});
    rows.push_back({name + ", not known",
                    "always",
                    [delay](Scene& s) { s.command_delay_s = delay; },
                    {"GOAL_REACHED"},
                    kArrives});
  }
  for (const int hundredths : {20, 50, 100})
    rows.push_back({"host asks every " + std::to_string(10 * hundredths) + " ms",
                    "always",
                    [hundredths](Scene& s) { s.cycle_steps = hundredths; },
                    {},
                    kAny});
  rows.push_back({"goal moved into a trunk",
                  "once",
                  [](Scene& s)
                  {
                    s.forest = test::AnalyticField({test::VerticalCylinder{{8.0, 1.0}, 0.75}});
                    s.faults.host = [told = false](double t, engine::Engine& engine) mutable
                    {
                      if (t >= kBegin_s && !std::exchange(told, true))
                        engine.setMission({Eigen::Vector3d(8.0, 1.0, 1.5)});
                      return true;
                    };
                  },
                  {"GOAL_BLOCKED"},
                  {EngineStatus::GoalBlocked, EngineStatus::GoalReached}});
  rows.push_back({"wall appears 2.5 m ahead",
                  "once",
                  [](Scene& s) { wallAhead(s, 2.5); },
                  {"GOAL_REACHED"},
                  kArrives});
  rows.push_back(
      {"wall appears 1.6 m ahead", "once", [](Scene& s) { wallAhead(s, 1.6); }, {}, kAny});
  for (const std::uint64_t seed : {1, 2})
    rows.push_back({"verbs at random, seed " + std::to_string(seed),
                    "2 to 16 s",
                    [seed](Scene& s) { randomVerbs(s, seed); },
                    {"GOAL_REACHED"},
                    kArrives});
  return rows;
}

std::vector<Fault> matrix()
{
  std::vector<Fault> rows;
  for (auto part : {stateFaults(), sensorFaults(), plannerFaults(), outerFaults()})
    rows.insert(rows.end(), part.begin(), part.end());
  return rows;
}

/// What came of a row.
struct Outcome
{
  test::FlightOutcome flight;
  std::vector<std::string> events;
  double rest_s = kForEver;  ///< after the begin of the fault
};

/// True if `wanted` happened in this order, whatever happened between.
bool inOrder(const std::vector<std::string>& wanted, const std::vector<std::string>& happened)
{
  auto next = wanted.begin();
  for (const std::string& event : happened)
    if (next != wanted.end() && *next == event) ++next;
  return next == wanted.end();
}

std::string joined(const std::vector<std::string>& words)
{
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : " ") + word;
  return text;
}

Outcome fly(const Fault& fault)
{
  Scene scene;
  fault.arrange(scene);
  const auto solid = [&scene](const Eigen::Vector3d& p) { return scene.distance(p); };
  FlightHarness harness(test::FlightWorld::of(solid), scene.config, scene.hooks);
  harness.azimuths = 90;
  harness.fusion = scene.fusion;
  harness.command_delay_s = scene.command_delay_s;
  harness.cycle_steps = scene.cycle_steps;
  harness.faults = scene.faults;
  harness.faults.world = [&](double t, const Eigen::Vector3d& p)
  {
    scene.t = t;
    if (scene.faults.world) scene.faults.world(t, p);
  };
  Outcome outcome;
  harness.listener = [&](const core::CycleRecord& cycle, const Eigen::Vector3d&)
  {
    for (const core::Event& event : cycle.events) outcome.events.push_back(event.name);
    if (std::getenv("SLALOM_FAULTS_VERBOSE"))
      for (const core::Event& event : cycle.events)
        std::cout << "  " << cycle.t << " " << event.name << ": " << event.detail << "\n";
    if (cycle.t >= kBegin_s && outcome.rest_s == kForEver && harness.velocity().norm() < 0.1)
      outcome.rest_s = cycle.t - kBegin_s;
  };
  // A vehicle that rests for good has shown what there is to see.
  double rested = 0.0;
  harness.over = [&, ends = harness.over](double t, EngineStatus status)
  {
    const bool verbs = scene.faults.host && t < 18.0;
    rested = t > kBegin_s && !verbs && harness.velocity().norm() < 0.02 ? rested + 0.05 : 0.0;
    return !verbs && (rested > 6.0 || (t > kBegin_s && ends(t, status)));
  };
  outcome.flight = harness.fly(kStart, scene.mission, scene.time_limit_s);
  scene.over = true;
  return outcome;
}

/// The rows as they came out, for people.
class Table : public testing::Environment
{
 public:
  static void add(const Fault& fault, const Outcome& outcome, bool held)
  {
    rows().push_back({fault.name, fault.when, joined(outcome.events),
                      std::string(toString(outcome.flight.status)),
                      outcome.rest_s < kForEver ? number(outcome.rest_s, 1) : "-",
                      number(outcome.flight.min_clearance_m, 2), held ? "yes" : "NO"});
  }
  void TearDown() override
  {
    std::ostringstream text;
    const auto line = [&text](const std::vector<std::string>& cells)
    {
      for (const std::string& cell : cells) text << "| " << cell << " ";
      text << "|\n";
    };
    line({"fault", "for how long", "events", "at the end", "seconds to rest", "least clearance [m]",
          "as expected"});
    line({"---", "---", "---", "---", "---", "---", "---"});
    for (const auto& row : rows()) line(row);
    std::cout << text.str();
    const char* directory = std::getenv("SLALOM_FAULTS_DIR");
    if (!directory) return;
    std::filesystem::create_directories(directory);
    std::ofstream(std::filesystem::path(directory) / "faults.md") << text.str();
  }

 private:
  static std::string number(double value, int digits)
  {
    std::ostringstream text;
    text.setf(std::ios::fixed);
    text.precision(digits);
    text << value;
    return text.str();
  }
  static std::vector<std::vector<std::string>>& rows()
  {
    static std::vector<std::vector<std::string>> all;
    return all;
  }
};
const testing::Environment* const table = testing::AddGlobalTestEnvironment(new Table);

class Faults : public testing::TestWithParam<Fault>
{
};

TEST_P(Faults, AreBounded)
{
  const Fault& fault = GetParam();
  SCOPED_TRACE(fault.name + ", " + fault.when);
  const Outcome outcome = fly(fault);
  EXPECT_GE(outcome.flight.min_clearance_m, fault.least_clearance_m) << "it must not hit anything";
  EXPECT_TRUE(outcome.flight.finite);
  EXPECT_TRUE(fault.ends.count(outcome.flight.status)) << toString(outcome.flight.status);
  EXPECT_TRUE(inOrder(fault.events, outcome.events))
      << "wanted " << joined(fault.events) << ", got " << joined(outcome.events);
  EXPECT_LE(fault.rest_s < kForEver ? outcome.rest_s : 0.0, fault.rest_s);
  Table::add(fault, outcome, !HasFailure());
}

std::string testName(const testing::TestParamInfo<Fault>& info)
{
  std::string name = info.param.name + "_" + info.param.when;
  for (char& c : name)
    if (!std::isalnum(static_cast<unsigned char>(c))) c = '_';
  return name;
}

/// A lidar of 0.5 Hz, as the settings are: one stop, one reason, and the end.
TEST(SlowSensor, IsOneStopThatNamesItsRateAndTheKey)
{
  const test::AnalyticField world = test::flightForest(4, 0.12, kLength);
  engine::EngineConfig config = test::flightConfig();
  FlightHarness harness(world, config);
  harness.azimuths = 90;
  harness.faults.sensor = [](core::Measurement& measurement)
  {
    const auto* scan = std::get_if<core::RangeScan>(&measurement);
    return !scan || std::lround(scan->t * 10.0) % 20 == 0;
  };
  std::vector<core::Event> events;
  harness.listener = [&](const core::CycleRecord& cycle, const Eigen::Vector3d&)
  { events.insert(events.end(), cycle.events.begin(), cycle.events.end()); };
  const test::FlightOutcome flight =
      harness.fly(kStart, {Eigen::Vector3d(kLength, 0.0, 1.5)}, 40.0);
  EXPECT_EQ(flight.status, EngineStatus::SensorLost) << toString(flight.status);
  EXPECT_EQ(flight.statistics.safe_stops, 1u);
  EXPECT_EQ(flight.statistics.safe_recoveries, 0u);
  ASSERT_FALSE(events.empty());
  EXPECT_EQ(events.back().name, "SENSOR_LOST");
  for (const char* word : {"every 2 s", "safety.map_timeout_s = 1 s", "mission.sensor_timeout_s"})
    EXPECT_NE(events.back().detail.find(word), std::string::npos) << events.back().detail;
  EXPECT_LT(flight.duration_s, 2.0 + 1.0 + config.mission.sensor_timeout_s + 1.0);
}

/// The time-out of the sensors ends what would never end, and nothing else: a mission in which they
/// come back in time arrives.
TEST(SilentSensor, LosesNothingWhenItComesBackInTime)
{
  for (const double silence_s : {3.0, 7.0})
  {
    SCOPED_TRACE(silence_s);
    Scene scene;
    loseAllBut(scene, silence_s, false);
    FlightHarness harness(scene.forest, scene.config);
    harness.azimuths = 90;
    harness.faults = scene.faults;
    harness.faults.world = [&](double t, const Eigen::Vector3d&) { scene.t = t; };
    const test::FlightOutcome flight = harness.fly(kStart, scene.mission, 60.0);
    EXPECT_EQ(flight.status, EngineStatus::GoalReached) << toString(flight.status);
    EXPECT_GE(flight.statistics.safe_stops, 1u);
    EXPECT_EQ(flight.statistics.safe_recoveries, flight.statistics.safe_stops);
  }
}

/// Nothing is wrong when the host changes its mind, and what nothing is wrong with goes unchanged.
TEST(Gate, DoesNotTouchTheCommandsOfAnEagerHost)
{
  const test::AnalyticField open({test::VerticalCylinder{{5.0, 9.0}, 0.3}});
  for (const double delay : {0.0, 0.15})
  {
    SCOPED_TRACE(delay);
    engine::EngineConfig config = test::flightConfig();
    config.vehicle.command_delay_s = delay;
    FlightHarness harness(open, config);
    harness.azimuths = 90;
    harness.command_delay_s = delay;
    core::Rng rng(3);
    double next = 1.5;
    harness.faults.host = [&](double t, engine::Engine& engine)
    {
      if (t < next) return true;
      next = t + rng.uniform(0.3, 2.0);
      if (rng.uniform(0.0, 1.0) < 0.3)
        engine.clearMission();
      else
        engine.setMission({Eigen::Vector3d(rng.uniform(-4.0, 4.0), rng.uniform(-4.0, 4.0), 1.5)});
      return true;
    };
    harness.over = [](double t, EngineStatus) { return t > 20.0; };
    const test::FlightOutcome outcome = harness.fly(kStart, {Eigen::Vector3d(4.0, 0.0, 1.5)}, 21.0);
    for (const auto& [reason, count] : outcome.statistics.gate)
      ADD_FAILURE() << reason << ", " << count << " times";
    EXPECT_EQ(outcome.statistics.safe_stops, 0u);
  }
}

TEST(Standstill, IsNotWhatADelayOfCommandsLooksLike)
{
  const test::AnalyticField open({test::VerticalCylinder{{5.0, 9.0}, 0.3}});
  engine::EngineConfig config = test::flightConfig();
  config.vehicle.max_speed_mps = 3.0;
  config.vehicle.max_acceleration_mps2 = 6.0;
  config.vehicle.command_delay_s = 0.4;
  FlightHarness harness(open, config);
  harness.azimuths = 90;
  harness.command_delay_s = 0.4;
  harness.listener = [](const core::CycleRecord& cycle, const Eigen::Vector3d&)
  { EXPECT_EQ(cycle.reason.find("does not follow"), std::string::npos) << cycle.t; };
  const auto outcome = harness.fly(kStart, {Eigen::Vector3d(kLength, 0.0, 1.5)}, 20.0);
  EXPECT_EQ(outcome.status, EngineStatus::GoalReached);
}

/// What a pilot does with a suspended vehicle is not the wind's doing.
TEST(Suspended, NothingIsLearnedFromThePilot)
{
  const test::AnalyticField open({test::VerticalCylinder{{5.0, 9.0}, 0.3}});
  double now = 0.0, most = 0.0;  // [m/s^2] that the resumed planner takes for wind
  engine::StepHooks hooks;
  hooks.local = [&](local_planner::LocalPlannerInput& input)
  {
    if (now > 8.0) most = std::max(most, input.disturbance_W.norm());
  };
  FlightHarness harness(open, test::flightConfig(), hooks);
  harness.azimuths = 90;
  harness.faults.host = [&now](double t, engine::Engine&)
  {
    now = t;
    return !(t > 3.0 && t < 8.0);
  };
  harness.faults.command = [](double t, core::VelocityCommand& command)
  {
    if (t > 3.0 && t < 8.0) command.v_W = Eigen::Vector3d(0.0, t < 7.5 ? -1.0 : 0.0, 0.0);
  };
  const auto outcome = harness.fly(kStart, {Eigen::Vector3d(kLength, 0.0, 1.5)}, 30.0);
  EXPECT_EQ(outcome.status, EngineStatus::GoalReached);
  EXPECT_LT(most, 0.3) << "there is no wind";
}

INSTANTIATE_TEST_SUITE_P(Matrix, Faults, testing::ValuesIn(matrix()), testName);

}  // namespace
}  // namespace slalom
