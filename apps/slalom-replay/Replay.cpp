// SPDX-License-Identifier: BSD-3-Clause
#include "Replay.h"

#include <mrpt/config/CConfigFileMemory.h>

#include <chrono>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <thread>

#include "Preflight.h"
#include "Progress.h"
#include "RecordingClock.h"
#include "ReplayRobot.h"
#include "ReplaySettings.h"
#include "Sha256.h"
#include "Verify.h"
#include "slalom/core/CycleRecord.h"
#include "slalom/engine/Mission.h"
#include "slalom/mrpt_io/MemoryLimit.h"
#include "slalom/mrpt_io/RawlogReader.h"
#include "slalom/report/FlightReport.h"
#include "slalom/report/OutputFolder.h"
#include "slalom/spline/WaypointFile.h"

namespace slalom::replay
{
namespace
{
using app::ExitCode;

constexpr std::size_t kAddressSpace = std::size_t{4}
                                      << 30;  // a damaged length field must not take the machine

app::ReplaySettings readSettings(const Options& options)
{
  mrpt_io::IniDocument document = options.common.document();
  if (options.threaded) document.set("engine.threaded=true");
  return app::readReplaySettings(document);
}

engine::Mission readMission(const std::filesystem::path& file)
{
  try
  {
    return {spline::readWaypoints(file).points_W};
  }
  catch (const std::runtime_error& error)
  {
    throw mrpt_io::ConfigError(error.what());
  }
}

navigator::NavigationParams3D goalOf(const engine::Mission& mission, double tolerance)
{
  navigator::NavigationParams3D goal;
  const auto point = [&](Eigen::Index i)
  {
    const Eigen::Vector3d p = mission.waypoints_W.col(i);
    return mrpt::math::TPoint3D(p.x(), p.y(), p.z());
  };
  const Eigen::Index last = mission.waypoints_W.cols() - 1;
  for (Eigen::Index i = 0; i < last; ++i) goal.waypoints.push_back(point(i));
  const mrpt::math::TPoint3D end = point(last);
  goal.target3D = mrpt::math::TPose3D(end.x, end.y, end.z, 0.0, 0.0, 0.0);
  goal.allowed_distance_m = tolerance;
  return goal;
}

class Replay
{
 public:
  explicit Replay(const Options& options);
  int run();

 private:
  void openNavigator();
  void play();
  void stepTo(double until);
  void keepPace(double elapsed) const;
  void onCycle(const core::CycleRecord& cycle);
  void openReport();
  [[nodiscard]] report::RunResult judge() const;
  [[nodiscard]] report::RunResult finalResult() const;
  [[nodiscard]] double realtimeFactor() const;
  void checkVerify() const;
  void prepareFolder() const;
  [[nodiscard]] report::RunSummary summarise(report::RunResult result) const;
  int finish();

  const Options& options_;
  app::ReplaySettings settings_;
  std::optional<engine::Mission> mission_;
  Preflight preflight_;
  mrpt_io::RawlogReader reader_;
  ReplayRobot robot_;
  std::unique_ptr<navigator::AbstractNavigator3D> navigator_;
  std::unique_ptr<report::FlightReport> report_;
  std::vector<core::TimedPose> early_truth_;  // before the first cycle opens the report
  RecordingClock clock_;
  double next_step_ = 0.0;  // Unix time [s]
  std::string damage_, output_error_;
  std::string last_status_;
  double last_distance_to_goal_ = 0.0;
  bool goal_reached_ = false;
  std::chrono::steady_clock::time_point wall_start_ = std::chrono::steady_clock::now();
  double wall_s_ = 0.0;
};

Replay::Replay(const Options& options)
    : options_(options), settings_(readSettings(options)), reader_(options.rawlog)
{
  const auto file = options.mission.empty() ? settings_.missionFile() : options.mission;
  if (!file.empty()) mission_ = readMission(file);
  preflight_ = inspect(options.rawlog, settings_.input.truth_label, settings_.engine.state.wait_s);
  if (settings_.engine.state.source == engine::StateSourceKind::Auto)
  {
    static constexpr const char* kNames[] = {"auto", "fusion", "pose_observation", "static",
                                             "truth"};
    const auto best = preflight_.bestSource();
    settings_.document.set(std::string("state.source=") + kNames[static_cast<int>(best)]);
    if (best == engine::StateSourceKind::Static)
      std::cerr << "slalom-replay: warning: no position source in " << options.rawlog.string()
                << ": the vehicle is taken to stand still at the origin\n";
  }
}

void Replay::openNavigator()
{
  navigator::NavigatorFactory::loadModule(settings_.replay.plugin);
  const auto factory = navigator::NavigatorFactory::named(settings_.replay.navigator);
  navigator_ = factory->create(robot_);
  mrpt::config::CConfigFileMemory config;
  settings_.document.copyTo(config);
  navigator_->loadConfigFile(config);
  navigator_->setCycleListener([this](const core::CycleRecord& cycle) { onCycle(cycle); });
  navigator_->setTruthListener(
      [this](double t, const mrpt::math::TPose3D& pose)
      {
        core::TimedPose timed;
        timed.t = t;
        timed.position = {pose.x, pose.y, pose.z};
        mrpt::math::CQuaternionDouble q;
        pose.getAsQuaternion(q);
        timed.orientation = Eigen::Quaterniond(q.r(), q.x(), q.y(), q.z());
        if (report_)
          report_->addTruth(timed);
        else
          early_truth_.push_back(timed);
      });
  navigator_->initialize();
  if (mission_)
  {
    const auto goal = goalOf(*mission_, settings_.engine.mission.goal_tolerance_m);
    navigator_->navigate(&goal);
  }
}

void Replay::openReport()
{
  report::RunInfo info;
  const auto statistics = nlohmann::json::parse(navigator_->runStatisticsJson());
  info.title = options_.rawlog.filename().string();
  info.epoch_s = statistics.value("epoch_s", 0.0);
  info.vehicle_radius_m = info.hard_clearance_m = settings_.engine.vehicle.radius_m;
  info.wanted_clearance_m = settings_.engine.global_planner.clearance_m;
  info.max_speed_mps = settings_.engine.vehicle.max_speed_mps;
  info.setpoint_lead_s = settings_.engine.local_planner.step_s;
  info.map_deadline_s = info.global_deadline_s = settings_.engine.rates.global_period_s;
  info.local_deadline_s = settings_.engine.rates.local_period_s;
  info.effective_ini = settings_.effective;
  info.version = SLALOM_VERSION;
  info.build = SLALOM_BUILD_TYPE;
  info.method = settings_.replay.method;
  info.config_sha256 = sha256OfText(settings_.effective);
  info.threads = settings_.engine.rates.threaded ? 3 : 1;
  info.rawlog = options_.rawlog.filename().string();
  info.rawlog_sha256 = sha256OfFile(options_.rawlog);
  report_ = std::make_unique<report::FlightReport>(settings_.report, options_.common.out,
                                                   std::move(info));
  for (const core::TimedPose& pose : early_truth_) report_->addTruth(pose);
  early_truth_.clear();
}

void Replay::onCycle(const core::CycleRecord& cycle)
{
  if (!report_) openReport();
  last_status_ = cycle.status;
  goal_reached_ = goal_reached_ || cycle.status == "GOAL_REACHED";
  if (cycle.reference.cols() > 0) last_distance_to_goal_ = cycle.distance_to_goal_m;
  report_->add(cycle);
}

void Replay::keepPace(double elapsed) const
{
  if (options_.rate <= 0.0) return;
  std::this_thread::sleep_until(
      wall_start_ +
      std::chrono::duration_cast<std::chrono::nanoseconds>(
          std::chrono::duration<double>((elapsed - options_.start_s) / options_.rate)));
}

void Replay::stepTo(double until)
{
  const double period = settings_.engine.rates.local_period_s;
  for (; next_step_ <= until; next_step_ += period)
  {
    const auto now = mrpt::Clock::fromDouble(next_step_);
    mrpt::Clock::setSimulatedTime(now);
    robot_.setTime(now);
    navigator_->navigationStep();
  }
}

void Replay::play()
{
  constexpr double kSettle_s = 0.3;  // the last scans wait for the estimate to pass them
  mrpt::Clock::setActiveClock(mrpt::Clock::Source::Simulated);
  app::Progress progress("replay", options_.common.quiet);
  bool playing = false;
  try
  {
    while (const auto observation = reader_.next())
    {
      if (app::interrupted()) break;
      const double stamp = mrpt::Clock::toDouble(observation->timestamp);
      const bool jumped = clock_.advance(stamp);
      if (clock_.elapsed() < options_.start_s) continue;
      if (clock_.elapsed() > options_.start_s + options_.duration_s) break;
      if (!playing || jumped) next_step_ = clock_.now();
      playing = true;
      stepTo(clock_.now());
      robot_.deliver(observation);
      keepPace(clock_.elapsed());
      progress.show(reader_.progress(), last_status_);
    }
  }
  catch (const mrpt_io::RawlogError& error)
  {
    damage_ = error.what();  // what lies before the damage is reported all the same
  }
  if (playing) stepTo(clock_.now() + kSettle_s);
}

report::RunResult Replay::judge() const
{
  report::RunResult result;
  const auto set = [&result](int code, const char* name, std::string message)
  {
    result.code = code;
    result.name = name;
    result.message = std::move(message);
    result.success = code == ExitCode::kDone;
  };
  char distance[64];
  std::snprintf(distance, sizeof distance, "%.2f m", last_distance_to_goal_);
  if (!output_error_.empty())
    set(ExitCode::kInternalError, "OUTPUT_FAILED", output_error_);
  else if (!damage_.empty())
    set(ExitCode::kBadInput, "INPUT_DAMAGED", damage_);
  else if (app::interrupted())
    set(ExitCode::kInterrupted, "INTERRUPTED",
        "interrupted; the report holds what was played until then");
  else if (!report_)
    set(ExitCode::kBadInput, "NOTHING_TO_PLAY",
        "no observation between --start and --start + --duration");
  else if (!mission_)
    set(ExitCode::kDone, preflight_.volumetric_range ? "MAPPED" : "ESTIMATED",
        "no mission: played to the end");
  else if (goal_reached_)
    set(ExitCode::kDone, "GOAL_REACHED", "within the tolerance of the goal");
  else if (last_status_ == "GOAL_BLOCKED")
    set(ExitCode::kGoalNotReached, "GOAL_BLOCKED",
        "the goal lies in an obstacle; stopped " + std::string(distance) + " short");
  else if (last_status_ == "UNREACHABLE")
    set(ExitCode::kGoalNotReached, "UNREACHABLE",
        "no way on was found, " + std::string(distance) + " before the goal");
  else if (last_status_ == "WAITING_FOR_STATE")
    set(ExitCode::kGoalNotReached, "NO_STATE", "the estimator never had enough to start");
  else
    set(ExitCode::kGoalNotReached, "TIMEOUT",
        "the recording ends " + std::string(distance) + " before the goal");
  return result;
}

double Replay::realtimeFactor() const
{
  return wall_s_ > 0.0 ? (clock_.elapsed() - options_.start_s) / wall_s_ : 0.0;
}

void Replay::prepareFolder() const
{
  try
  {
    report::prepareOutputFolder(options_.common.out, options_.common.overwrite);
  }
  catch (const report::OutputError& error)
  {
    throw app::UsageError(error.what());
  }
}

report::RunSummary Replay::summarise(report::RunResult result) const
{
  report::RunSummary summary;
  summary.result = std::move(result);
  summary.input.duration_s = clock_.elapsed();
  summary.input.observations = reader_.statistics().observations;
  const auto statistics = nlohmann::json::parse(navigator_->runStatisticsJson());
  summary.input.dropped = statistics.value("dropped", std::map<std::string, std::uint64_t>{});
  for (const auto& [reason, count] : reader_.statistics().skipped)
    summary.input.dropped[reason] += count;
  if (const auto points = statistics.find("points_per_scan");
      points != statistics.end() && points->is_object())
  {
    if ((*points)["median"].is_number())
      summary.input.points_per_scan_median = (*points)["median"].get<double>();
    if ((*points)["max"].is_number())
      summary.input.points_per_scan_max = (*points)["max"].get<double>();
  }
  summary.realtime_factor = realtimeFactor();
  return summary;
}

/// What the run amounts to when deadlines and an earlier run have their say; a worse finding is not
/// covered up.
report::RunResult Replay::finalResult() const
{
  report::RunResult result = judge();
  const double factor = realtimeFactor(), wanted = settings_.replay.min_realtime_factor;
  if (result.code == ExitCode::kDone && factor < wanted)
  {
    result.code = ExitCode::kDeadlineMissed;
    result.success = false;
    result.message += "; deadline objective missed: " + std::to_string(factor) +
                      " times real time, wanted " + std::to_string(wanted);
  }
  return result;
}

int Replay::finish()
{
  const report::RunSummary summary = summarise(finalResult());
  if (!report_)
    throw mrpt_io::RawlogError(options_.rawlog.string() + ": " + summary.result.message);
  if (settings_.engine.mapping.keep_octree && preflight_.volumetric_range &&
      !navigator_->writeMap((options_.common.out / "map.bt").string()))
    std::cerr << "slalom-replay: warning: map.bt could not be written\n";
  report_->finish(summary);
  std::cout << summary.result.name << ": " << summary.result.message << "\n";
  if (options_.verify.empty()) return summary.result.code;

  const Verdict verdict = compareRuns(options_.verify, options_.common.out);
  std::cout << (verdict.equal ? "verified: " : "NOT EQUAL: ") << verdict.message << "\n";
  const bool worse_already =
      summary.result.code != ExitCode::kDone && summary.result.code != ExitCode::kGoalNotReached;
  return verdict.equal || worse_already ? summary.result.code : int(ExitCode::kRegression);
}

/// A --verify that could only compare a run with itself, or with nothing, is a mistake of the
/// caller.
void Replay::checkVerify() const
{
  if (options_.verify.empty()) return;
  if (!std::filesystem::exists(options_.verify / "cycles.csv"))
    throw app::UsageError("--verify: " + options_.verify.string() + " holds no cycles.csv");
  std::error_code error;
  if (std::filesystem::equivalent(options_.verify, options_.common.out, error))
    throw app::UsageError("--verify and --out are the same folder");
}

int Replay::run()
{
  if (options_.dry_run)
  {
    std::cout << "configuration and inputs are good\n" << settings_.effective;
    return ExitCode::kDone;
  }
  if (options_.common.out.empty()) throw app::UsageError("--out: an output folder is needed");
  checkVerify();
  prepareFolder();
  openNavigator();
  wall_start_ = std::chrono::steady_clock::now();
  try
  {
    play();
  }
  catch (const report::OutputError& error)
  {
    output_error_ = error.what();  // finish() keeps what was written before
  }
  wall_s_ = std::chrono::duration<double>(std::chrono::steady_clock::now() - wall_start_).count();
  return finish();
}

}  // namespace

int run(const Options& options)
{
  mrpt_io::limitMemory(kAddressSpace);
  try
  {
    return Replay(options).run();
  }
  catch (const report::OutputError& error)
  {
    // The folder was good at the start: the disk ran full, or somebody took it away. What was
    // written is kept.
    std::cerr << "slalom-replay: " << error.what() << "\n";
    return ExitCode::kInternalError;
  }
}

}  // namespace slalom::replay
