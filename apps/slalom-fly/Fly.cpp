// SPDX-License-Identifier: BSD-3-Clause
#include "Fly.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <iostream>
#include <map>
#include <optional>

#include "FlightHost.h"
#include "FlightRequest.h"
#include "InputFiles.h"
#include "Progress.h"
#include "SimulatedRobot.h"
#include "slalom/mrpt_io/RawlogWriter.h"
#include "slalom/report/AtomicFile.h"
#include "slalom/simulation/ShortestPath.h"

namespace slalom::fly
{
namespace
{
using app::ExitCode;
using simulation::FlightTruth;

/// Text as one cell of a CSV row.
std::string quoted(const std::string& text)
{
  std::string cell = "\"";
  for (const char c : text)
  {
    if (c == '"') cell += '"';
    cell += c == '\n' || c == '\r' ? ' ' : c;
  }
  return cell + '"';
}

navigator::State3D stateOf(const simulation::MotionSample& m, mrpt::Clock::time_point now)
{
  const Eigen::Matrix3d r = m.q_WB.toRotationMatrix();
  navigator::State3D state;
  state.pose = {m.p_W.x(),
                m.p_W.y(),
                m.p_W.z(),
                std::atan2(r(1, 0), r(0, 0)),
                -std::asin(std::clamp(r(2, 0), -1.0, 1.0)),
                std::atan2(r(2, 1), r(2, 2))};
  state.twist = {m.v_W.x(), m.v_W.y(), m.v_W.z(), m.w_B.x(), m.w_B.y(), m.w_B.z()};
  state.time = now;
  return state;
}

class Fly
{
 public:
  Fly(const Options& options, FlightRequest request);
  int run();

 private:
  void openFiles();
  void fly();
  void tick();
  void observe(const mrpt::obs::CObservation::Ptr& observation);
  void writeEvents();
  [[nodiscard]] std::optional<report::RunResult> outcome();
  [[nodiscard]] report::RunResult contactResult() const;
  [[nodiscard]] report::RunSummary summarise() const;
  [[nodiscard]] double goalDistance() const;
  [[nodiscard]] std::optional<double> shortest() const;
  [[nodiscard]] std::optional<double> stopError() const;
  int finish();

  const Options& options_;
  const FlightRequest request_;
  simulation::SimulatedFlight flight_;
  SimulatedRobot robot_;
  app::FlightHost host_;
  std::optional<mrpt_io::RawlogWriter> rawlog_;
  std::optional<report::AtomicFile> events_;
  std::map<std::string, std::uint64_t> observations_;
  double blocked_since_ = -1.0;  // [s]; negative: not blocked
  report::RunResult result_;
  report::TrueFlight true_flight_;  // when the mission ended
  double wall_s_ = 0.0;
};

Fly::Fly(const Options& options, FlightRequest request)
    : options_(options),
      request_(std::move(request)),
      flight_(request_.world, request_.settings.airframe, request_.settings.sensors, request_.start,
              options.seed),
      host_(request_.settings, request_.settings.fly, robot_, options.common.out)
{
}

report::RunResult resultOf(int code, const char* name, std::string message)
{
  return {code, name, std::move(message), code == ExitCode::kDone};
}

double Fly::goalDistance() const
{
  return (flight_.state().p_W - request_.goal()).norm();
}

/// From waypoint to waypoint, each leg as short as can be; nullopt if one cannot be flown.
std::optional<double> Fly::shortest() const
{
  double whole = 0.0;
  Eigen::Vector3d from = request_.start.p_W;
  for (const auto& waypoint : request_.mission.waypoints_W.colwise())
  {
    const Eigen::Vector3d to = waypoint;
    const auto leg = simulation::shortestPath(request_.world, from, to, request_.start.radius_m);
    if (!leg) return std::nullopt;
    whole += *leg;
    from = to;
  }
  return whole;
}

/// How far it stands from the best place to stand, for a vehicle that keeps the wanted clearance.
std::optional<double> Fly::stopError() const
{
  const Eigen::Vector3d here = flight_.state().p_W;
  const double radius = request_.start.radius_m;
  const auto best = simulation::nearestReachable(
      request_.world, request_.start.p_W, request_.goal(), here, radius,
      std::max(radius, request_.settings.engine.global_planner.clearance_m));
  return best ? std::optional((*best - here).norm()) : std::nullopt;
}

void Fly::openFiles()
{
  if (!options_.record.empty())
  {
    app::refuseExisting(options_.record, options_.common.overwrite);
    rawlog_.emplace(options_.record, request_.settings.sensors.record.gzip_level);
  }
  app::prepareFolder(options_.common.out, options_.common.overwrite);
  events_.emplace(options_.common.out / "events.csv");
  events_->write("t,event,detail\n");
}

void Fly::observe(const mrpt::obs::CObservation::Ptr& observation)
{
  const std::string name = observation->GetRuntimeClass()->className;
  ++observations_[name.substr(name.rfind(':') + 1)];
  if (rawlog_) rawlog_->write(*observation);
  robot_.deliver(observation);
}

void Fly::writeEvents()
{
  for (const HeardEvent& event : robot_.takeEvents())
  {
    char t[32];
    std::snprintf(t, sizeof t, "%.6f", event.unix_time - request_.settings.sensors.record.epoch_s);
    events_->write(std::string(t) + ',' + event.name + ',' + quoted(event.detail) + '\n');
  }
}

/// One period of the local planner: the world goes on, then the navigator thinks.
void Fly::tick()
{
  const double period = request_.settings.engine.rates.local_period_s;
  for (const auto& observation : flight_.advance(period, robot_.command())) observe(observation);
  const double now = request_.settings.sensors.record.epoch_s + flight_.time();
  robot_.setTime(mrpt::Clock::fromDouble(now));
  if (request_.settings.engine.state.source == engine::StateSourceKind::Truth)
    robot_.setState(stateOf(flight_.state(), robot_.now()));
  host_.step(now);
  writeEvents();
}

report::RunResult Fly::contactResult() const
{
  const simulation::Contact& contact = *flight_.truth().first_contact;
  char text[200];
  std::snprintf(text, sizeof text,
                "came within %.3f m of %s at t = %.2f s, (%.2f, %.2f, %.2f); the vehicle's "
                "radius is %.2f m",
                contact.distance, flight_.truth().hit_mover ? "a mover" : "the world", contact.t,
                contact.p_W.x(), contact.p_W.y(), contact.p_W.z(), request_.start.radius_m);
  return resultOf(ExitCode::kLimitViolated, "COLLISION", text);
}

/// How the mission ended, if it did.
std::optional<report::RunResult> Fly::outcome()
{
  const app::FlyConfig& config = request_.settings.fly;
  char distance[64];
  std::snprintf(distance, sizeof distance, "%.2f m from the goal", goalDistance());
  const std::string where = distance;
  const bool blocked = host_.status() == "GOAL_BLOCKED";
  if (!blocked) blocked_since_ = -1.0;
  if (blocked && blocked_since_ < 0.0) blocked_since_ = flight_.time();

  if (config.stop_at_contact && flight_.truth().first_contact) return contactResult();
  if (app::interrupted())
    return resultOf(ExitCode::kInterrupted, "INTERRUPTED",
                    "interrupted; the report holds what was flown until then");
  if (host_.goalReached() || robot_.navigationEnded())
    return resultOf(ExitCode::kDone, "GOAL_REACHED", where);
  if (host_.status() == "UNREACHABLE")
    return resultOf(ExitCode::kGoalNotReached, "UNREACHABLE", "no way on was found, " + where);
  if (host_.status() == "SENSOR_LOST")
    return resultOf(ExitCode::kGoalNotReached, "SENSOR_LOST",
                    "stopped " + where + ": " + robot_.lastDetail());
  if (robot_.navigationFailed())
    return resultOf(ExitCode::kGoalNotReached, "FAILED",
                    "the navigator gave up, " + where + ": " + robot_.lastDetail());
  if (blocked && flight_.time() - blocked_since_ >= config.blocked_s)
    return resultOf(ExitCode::kGoalNotReached, "GOAL_BLOCKED",
                    "the goal cannot be reached; stopped " + where);
  if (flight_.time() >= config.time_limit_s)
    return resultOf(ExitCode::kGoalNotReached, "TIMEOUT", "the time is over, " + where);
  return std::nullopt;
}

void Fly::fly()
{
  const double straight = (request_.goal() - request_.start.p_W).norm();
  app::Progress progress("fly", options_.common.quiet);
  std::optional<report::RunResult> ended;
  while (!ended)
  {
    tick();
    ended = outcome();
    const double share = straight > 0.0 ? 1.0 - goalDistance() / straight : 0.0;
    progress.show(std::max(share, flight_.time() / request_.settings.fly.time_limit_s),
                  host_.status());
  }
  result_ = std::move(*ended);
  const FlightTruth truth = flight_.truth();
  true_flight_.duration_s = truth.t;
  true_flight_.length_m = truth.length_m;
  true_flight_.straight_m = straight;
  true_flight_.goal_distance_m = goalDistance();
  true_flight_.max_speed_mps = truth.max_speed_mps;
  true_flight_.max_acceleration_mps2 = truth.max_acceleration_mps2;
  true_flight_.acceleration_effort_m2_s3 = truth.acceleration_effort;
  true_flight_.jerk_effort_m2_s5 = truth.jerk_effort;
  true_flight_.clearance_p05_m = truth.clearances.quantile(0.05);
  true_flight_.shortest_m = shortest();
  if (result_.name == "GOAL_BLOCKED") true_flight_.stop_error_m = stopError();
  // A vehicle that reaches its goal too fast to stop there has not arrived.
  const double until = flight_.time() + request_.settings.fly.settle_s;
  while (!truth.first_contact && flight_.time() < until && !app::interrupted()) tick();
  true_flight_.contacts = flight_.truth().contacts;
  if (!request_.world.movers().empty())
    true_flight_.min_mover_distance_m = flight_.truth().nearest_mover.distance;
  if (flight_.truth().first_contact && result_.code != ExitCode::kInterrupted)
    result_ = contactResult();
}

report::RunSummary Fly::summarise() const
{
  report::RunSummary summary;
  summary.result = result_;
  summary.input = host_.inputSummary();
  summary.input.duration_s = flight_.time();
  summary.input.observations = observations_;
  summary.goal_error_m = true_flight_.goal_distance_m;
  summary.min_true_clearance_m = flight_.truth().nearest.distance;
  summary.realtime_factor = wall_s_ > 0.0 ? flight_.time() / wall_s_ : 0.0;
  summary.flight = true_flight_;
  const double wanted = request_.settings.fly.min_realtime_factor;
  if (result_.code == ExitCode::kDone && *summary.realtime_factor < wanted)
    summary.result = resultOf(ExitCode::kDeadlineMissed, result_.name.c_str(),
                              result_.message + "; deadline objective missed: " +
                                  std::to_string(*summary.realtime_factor) +
                                  " times real time, wanted " + std::to_string(wanted));
  return summary;
}

int Fly::finish()
{
  const report::RunSummary summary = summarise();
  if (rawlog_) rawlog_->close();
  events_->commit();
  host_.finish(summary, host_.hasReport());
  std::cout << summary.result.name << ": " << summary.result.message << "\n";
  return summary.result.code;
}

int Fly::run()
{
  openFiles();
  host_.open(
      [this](report::RunInfo& info)
      {
        info.title = options_.world.filename().string();
        info.epoch_s = request_.settings.sensors.record.epoch_s;
        info.seed = options_.seed;
      });
  host_.navigate(request_.mission);
  const auto start = std::chrono::steady_clock::now();
  try
  {
    fly();
  }
  catch (const report::OutputError& error)
  {
    result_ = resultOf(ExitCode::kInternalError, "OUTPUT_FAILED", error.what());
  }
  wall_s_ = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return finish();
}
}  // namespace

int run(const Options& options)
{
  try
  {
    FlightRequest request = readRequest(options);
    std::optional<Fly> flight;
    try
    {
      flight.emplace(options, std::move(request));
    }
    catch (const std::invalid_argument& error)
    {
      throw app::InputError(error.what());
    }
    return flight->run();
  }
  catch (const app::InputError& error)
  {
    std::cerr << "slalom-fly: " << error.what() << "\n";
    return ExitCode::kBadInput;
  }
  catch (const report::OutputError& error)
  {
    std::cerr << "slalom-fly: " << error.what() << "\n";
    return ExitCode::kInternalError;
  }
}

}  // namespace slalom::fly
