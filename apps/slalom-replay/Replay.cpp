// SPDX-License-Identifier: BSD-3-Clause
#include "Replay.h"

#include <chrono>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>
#include <optional>
#include <thread>

#include "FlightHost.h"
#include "Preflight.h"
#include "Progress.h"
#include "RecordingClock.h"
#include "ReplayRobot.h"
#include "ReplaySettings.h"
#include "Sha256.h"
#include "Verify.h"
#include "slalom/mrpt_io/MemoryLimit.h"
#include "slalom/mrpt_io/RawlogReader.h"
#include "slalom/report/AtomicFile.h"

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
  document.set("engine.open_loop=true");
  if (options.threaded) document.set("engine.threaded=true");
  return app::readReplaySettings(document);
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
  [[nodiscard]] report::RunResult judge() const;
  [[nodiscard]] report::RunResult finalResult() const;
  [[nodiscard]] double realtimeFactor() const;
  void checkVerify() const;
  [[nodiscard]] report::RunSummary summarise(report::RunResult result) const;
  void addVerdict(const Verdict& verdict, int code) const;
  int finish();

  const Options& options_;
  app::ReplaySettings settings_;
  std::optional<engine::Mission> mission_;
  Preflight preflight_;
  mrpt_io::RawlogReader reader_;
  ReplayRobot robot_;
  app::FlightHost host_;
  RecordingClock clock_;
  double next_step_ = 0.0;  // Unix time [s]
  std::string damage_, output_error_;
  std::chrono::steady_clock::time_point wall_start_ = std::chrono::steady_clock::now();
  double wall_s_ = 0.0;
};

Replay::Replay(const Options& options)
    : options_(options),
      settings_(readSettings(options)),
      reader_(options.rawlog),
      host_(settings_, settings_.replay, robot_, options.common.out)
{
  const auto file = options.mission.empty() ? settings_.missionFile() : options.mission;
  if (!file.empty()) mission_ = app::readMission(file, settings_.engine);
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
  host_.open(
      [this](report::RunInfo& info)
      {
        info.title = info.rawlog = options_.rawlog.filename().string();
        info.rawlog_sha256 = app::sha256OfFile(options_.rawlog);
      });
  if (mission_) host_.navigate(*mission_);
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
    robot_.setTime(mrpt::Clock::fromDouble(next_step_));
    host_.step(next_step_);
  }
}

void Replay::play()
{
  constexpr double kSettle_s = 0.3;  // the last scans wait for the estimate to pass them
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
      progress.show(reader_.progress(), host_.status());
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
  std::snprintf(distance, sizeof distance, "%.2f m", host_.distanceToGoal());
  if (!output_error_.empty())
    set(ExitCode::kInternalError, "OUTPUT_FAILED", output_error_);
  else if (!damage_.empty())
    set(ExitCode::kBadInput, "INPUT_DAMAGED", damage_);
  else if (app::interrupted())
    set(ExitCode::kInterrupted, "INTERRUPTED",
        "interrupted; the report holds what was played until then");
  else if (!host_.hasReport())
    set(ExitCode::kBadInput, "NOTHING_TO_PLAY",
        "no observation between --start and --start + --duration");
  else if (!mission_)
    set(ExitCode::kDone, preflight_.volumetric_range ? "MAPPED" : "ESTIMATED",
        "no mission: played to the end");
  else if (host_.goalReached())
    set(ExitCode::kDone, "GOAL_REACHED", "within the tolerance of the goal");
  else if (host_.status() == "GOAL_BLOCKED")
    set(ExitCode::kGoalNotReached, "GOAL_BLOCKED",
        "the goal lies in an obstacle; stopped " + std::string(distance) + " short");
  else if (host_.status() == "UNREACHABLE")
    set(ExitCode::kGoalNotReached, "UNREACHABLE",
        "no way on was found, " + std::string(distance) + " before the goal");
  else if (host_.status() == "SENSOR_LOST")
    set(ExitCode::kGoalNotReached, "SENSOR_LOST",
        "a sensor is silent or too slow at the end, " + std::string(distance) +
            " before the goal; cycles.csv says which");
  else if (host_.status() == "WAITING_FOR_STATE")
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

report::RunSummary Replay::summarise(report::RunResult result) const
{
  report::RunSummary summary;
  summary.result = std::move(result);
  summary.input = host_.inputSummary();
  summary.input.duration_s = clock_.elapsed();
  summary.input.observations = reader_.statistics().observations;
  for (const auto& [reason, count] : reader_.statistics().skipped)
    summary.input.dropped[reason] += count;
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

/// metrics.json is there before the runs can be compared; the verdict becomes part of it.
void Replay::addVerdict(const Verdict& verdict, int code) const
{
  const auto file = options_.common.out / "metrics.json";
  std::ifstream in(file);
  auto json = nlohmann::ordered_json::parse(in);
  json["verify"] = {{"against", options_.verify.string()},
                    {"equal", verdict.equal},
                    {"message", verdict.message}};
  if (code == ExitCode::kRegression)
  {
    json["result"]["code"] = code;
    json["result"]["message"] =
        json["result"]["message"].get<std::string>() + "; not equal: " + verdict.message;
    json["success"] = false;
  }
  report::writeFileAtomically(file, json.dump(2) + "\n");
}

int Replay::finish()
{
  const report::RunSummary summary = summarise(finalResult());
  if (!host_.hasReport())
    throw mrpt_io::RawlogError(options_.rawlog.string() + ": " + summary.result.message);
  host_.finish(summary, preflight_.volumetric_range);
  std::cout << summary.result.name << ": " << summary.result.message << "\n";
  if (options_.verify.empty()) return summary.result.code;

  const Verdict verdict = compareRuns(options_.verify, options_.common.out);
  std::cout << (verdict.equal ? "verified: " : "NOT EQUAL: ") << verdict.message << "\n";
  const bool worse_already =
      summary.result.code != ExitCode::kDone && summary.result.code != ExitCode::kGoalNotReached;
  const int code =
      verdict.equal || worse_already ? summary.result.code : int(ExitCode::kRegression);
  addVerdict(verdict, code);
  return code;
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
  app::prepareFolder(options_.common.out, options_.common.overwrite);
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
