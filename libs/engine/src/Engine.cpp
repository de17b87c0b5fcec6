// SPDX-License-Identifier: BSD-3-Clause
#include "slalom/engine/Engine.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

#include "Describe.h"
#include "EngineImpl.h"
#include "Handover.h"

namespace slalom::engine
{
std::string_view toString(EngineStatus status)
{
  switch (status)
  {
    case EngineStatus::WaitingForState:
      return "WAITING_FOR_STATE";
    case EngineStatus::NoMission:
      return "NO_MISSION";
    case EngineStatus::Navigating:
      return "NAVIGATING";
    case EngineStatus::GoalReached:
      return "GOAL_REACHED";
    case EngineStatus::GoalBlocked:
      return "GOAL_BLOCKED";
    case EngineStatus::Unreachable:
      return "UNREACHABLE";
    case EngineStatus::SensorLost:
      return "SENSOR_LOST";
  }
  return "?";
}

/// The command that the vehicle should fly as far as map, reference and planners know.
core::VelocityCommand Engine::Impl::run(Cycle& cycle)
{
  core::CycleRecord& record = cycle.record;
  mapPending(record.t);
  if (const auto map = currentMap()) record.movers = map->movers;
  const auto state = source.state(record.t);
  if (!state)
  {
    status = EngineStatus::WaitingForState;
    const core::VelocityCommand halt = stop(cycle, "no state estimate yet (" + source.name() + ")");
    giveUpWithoutSensors(cycle);
    return halt;
  }
  record.state = *state;
  predictor.observe(*state);
  const bool obeys = cycle.drive && flight && !config.rates.open_loop;
  standstill.update(*state, predictor.inEffect(record.t), obeys ? cycle.dt : 0.0);
  cycle.ahead = predictor.at(*state, predictor.effectOf(record.t));
  record.has_state = true;
  std::string refusal;
  if (waiting_mission && source.onlyAssumed())
    refusal = "no position source: a mission cannot be flown";
  else if (waiting_mission)
    refusal = startMission(cycle.ahead);
  if (flight)
  {
    followDrift(*state, cycle.dt);
    takeRefinement(record);
    requestRefinement(cycle.ahead, record.t);
    takeRefinement(record);  // at once, unless the planner runs in a thread of its own
  }
  const core::VelocityCommand wanted = flight && cycle.drive
                                           ? plan(cycle)
                                           : stop(cycle, flight            ? "suspended"
                                                         : refusal.empty() ? "no mission"
                                                                           : refusal);
  constexpr double kMeasurable = 0.01;
  record.verified_stop =
      !flight || state->v_W.norm() < kAtRest_mps ||
      (record.committed.cols() > 0 && refinements.explanation().stop_excess <= kMeasurable);
  const bool could_go =
      cycle.drive && (record.refined.cols() > 0 || standstill.stuck() || scan_refused);
  status = flight ? judge.judge(*flight, refinements, onReference(), record, cycle.dt, could_go)
                  : EngineStatus::NoMission;
  giveUpWithoutSensors(cycle);
  if (flight && cycle.drive && cycle.unsafe.empty()) cycle.unsafe = doubt(record);
  return wanted;
}

/// A stop for want of a sensor ends the mission when it lasts.
void Engine::Impl::giveUpWithoutSensors(Cycle& cycle)
{
  // Scans that contradict the map are heard; the judge ends a mission that waits for better ones.
  if (!flight || !cycle.drive || scan_refused) return sensors.reset();
  const double t = cycle.record.t;
  std::optional<double> map_age_s;
  if (const auto map = currentMap())
    map_age_s = t - map->field->stamp();
  else if (config.rates.require_map || pipeline.latestMap())
    map_age_s = std::numeric_limits<double>::infinity();
  std::string missing = sensors.missing(t, source, map_age_s);
  if (missing.empty() ||
      (status != EngineStatus::Navigating && status != EngineStatus::WaitingForState))
    return;
  status = EngineStatus::SensorLost;
  cycle.record.reason = std::move(missing);
}

/// What is left of the local planner's period; with everything in one thread only caps bound it.
core::Deadline Engine::Impl::localDeadline(const Cycle& cycle) const
{
  if (!config.rates.threaded) return core::Deadline::none();
  const double left = std::max(0.0, config.rates.local_period_s - cycle.watch.seconds());
  return core::Deadline::in(
      std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::duration<double>(left)));
}

/// Where the plan wants the vehicle to be now: what was its point of effect a delay ago.
Eigen::Vector3d Engine::Impl::pointDue(double t, const Eigen::Vector3d& point_of_effect_L)
{
  constexpr double kSameTime_s = 1e-6;
  due.emplace_back(predictor.effectOf(t), point_of_effect_L);
  while (due.size() > 1 && due[1].first <= t + kSameTime_s) due.pop_front();
  const auto& [since, from] = due.front();
  if (due.size() == 1 || since >= t) return from;
  const auto& [until, to] = due[1];
  return from + (t - since) / (until - since) * (to - from);
}

/// Why the plan in force makes the vehicle brake for safety; empty if it does not.
std::string Engine::Impl::doubt(const core::CycleRecord& record) const
{
  if (record.committed.cols() == 0) return {};
  // Beyond this share the way to rest takes more than the vehicle's own limits, not only more than
  // plans may use of them.
  const double reserve = 1.0 / config.mission.acceleration_share - 1.0;
  if (!record.verified_stop && refinements.explanation().stop_excess > reserve)
    return "no verified way to stop within the limits: brake";
  return {};
}

core::VelocityCommand Engine::Impl::plan(Cycle& cycle)
{
  core::CycleRecord& record = cycle.record;
  local_planner::LocalPlannerInput input;
  input.state = cycle.ahead;
  input.last_command = last_command;
  input.elapsed_s = sinceLastCommand(cycle);
  input.deadline = localDeadline(cycle);
  input.disturbance_W = predictor.disturbance();
  input.movers = record.movers;
  const safety::SafetyConfig guard = config.guarded();
  const Eigen::Vector3d to_local = cycle.ahead.p_L - cycle.ahead.p_W;
  input.airspace_L = {guard.fenceMin() + to_local, guard.fenceMax() + to_local};
  Hold hold = handOver({config, *flight, refinements, source, currentMap(), record.t,
                        record.state.t, judge.blocked(), standstill.stuck(), scan_refused,
                        pipeline.latestMap() != nullptr, sensors.slowScans()},
                       input);
  if (input.reference)
  {
    clock.advance(cycle.dt, *input.reference, *input.law, input.state.p_L);
    input.progress = clock.progress();
    record.pace = clock.pace();
    record.refined_point_L = pointDue(record.t, input.reference->position(input.progress));
    describePlan(input, 2.0 * config.global_planner.horizon_m / config.vehicle.max_speed_mps,
                 record);
  }
  const Stopwatch watch;
  if (hooks.local) hooks.local(input);
  local_planner::LocalPlannerOutput output = local.step(input);
  record.timing.local = watch.seconds();
  if (record.timing.local > config.rates.local_period_s) ++statistics.late_local;

  const bool held = hold.kind != Hold::Kind::None;
  if (output.fallback == local_planner::Fallback::Shifted) ++statistics.fallback_shifted;
  if (output.fallback == local_planner::Fallback::Brake && !held) ++statistics.fallback_brake;
  const bool no_plan = output.fallback == local_planner::Fallback::Brake && !held;
  record.reason = held ? std::move(hold.reason) : std::move(output.reason);
  cycle.waiting = hold.kind == Hold::Kind::Waiting;
  if (hold.kind == Hold::Kind::Safety || no_plan) cycle.unsafe = record.reason;
  describeStep(output, record);
  return output.command;
}

/// Brings a moving command down within the vehicle's limits; without one, stands still.
core::VelocityCommand Engine::Impl::stop(Cycle& cycle, std::string reason)
{
  cycle.record.reason = std::move(reason);
  if (last_command.v_W.norm() == 0.0 && last_command.yaw_rate == 0.0) return {};
  local_planner::LocalPlannerInput input;
  input.state = cycle.ahead;
  input.last_command = last_command;
  input.elapsed_s = sinceLastCommand(cycle);
  return local.step(input).command;
}

/// Over how long the command may change [s]; planner and gate must agree on it.
double Engine::Impl::sinceLastCommand(const Cycle& cycle) const
{
  return cycle.dt > 0.0 ? cycle.dt : config.rates.local_period_s;
}

void Engine::Impl::describe(core::CycleRecord& record) const
{
  if (const auto map = currentMap())
  {
    record.field = map->field;
    record.map_sequence = map->field->sequence();
  }
  if (flight) describeMission(*flight, refinements, onReference(), record);
  if (refinements.refined()) record.reference_sequence = refinements.refined()->sequence;
  record.origin_offset_norm_m = (record.state.p_L - record.state.p_W).norm();
}

void Engine::Impl::finish(const Cycle& cycle)
{
  core::CycleRecord& record = cycle.record;
  if (const auto map = pipeline.latestMap(); map && map->count != seen_map)
  {
    statistics.map_updates = seen_map = map->count;
    record.timing.map = map->wall_s - map->transform_s;
    record.timing.edt = map->transform_s;
    if (map->wall_s > config.rates.global_period_s) ++statistics.late_map;
  }
  record.status = toString(status);
  record.events = events.update(
      {record.t, status, flight && cycle.drive, cycle.unsafe, cycle.waiting, record.reason});
  statistics.safe_stops = events.safeStops();
  statistics.safe_recoveries = events.recoveries();
  hash.add(record);
  record.decision_hash = hash.value();
  record.timing.estimate = std::exchange(estimate_s, 0.0);
  record.timing.cycle = cycle.watch.seconds() + record.timing.estimate;
  statistics.state_source = source.name();
  for (const auto& [reason, count] : source.counters().dropped)
    statistics.dropped["estimate: " + reason] = count;
  if (const std::uint64_t resets = source.counters().resets)
    statistics.dropped["estimate: restarts"] = resets;
  if (const std::uint64_t failures = pipeline.failures())
    statistics.dropped["step: internal error"] = failures;
}

Engine::Engine(const EngineConfig& config, StepHooks hooks)
{
  check(config);
  impl_ = std::make_unique<Impl>(config, std::move(hooks));
}

Engine::~Engine() = default;

void Engine::setMission(const Mission& mission)
{
  check(mission, impl_->config);
  clearMission();
  impl_->waiting_mission = mission;
  impl_->standstill.restart();
  // The host's word that the world is to be believed again.
  if (std::exchange(impl_->scan_refused, false)) ++impl_->map_frame;
}

void Engine::clearMission()
{
  impl_->flight.reset();
  impl_->waiting_mission.reset();
  impl_->refinements.forgetPlan();
  if (impl_->status != EngineStatus::WaitingForState) impl_->status = EngineStatus::NoMission;
}

void Engine::add(const core::Measurement& measurement)
{
  const Stopwatch watch;
  impl_->source.add(measurement);
  if (const auto* scan = std::get_if<core::RangeScan>(&measurement))
  {
    impl_->scans.add(*scan);
    impl_->scan_label = scan->label;
  }
  impl_->estimate_s += watch.seconds();
}

core::CycleRecord Engine::step(double t, bool drive)
{
  Impl& me = *impl_;
  const Stopwatch watch;
  core::CycleRecord record;
  if (!std::isfinite(t)) t = me.last_t.value_or(0.0);
  record.index = me.statistics.cycles++;
  record.t = t;
  const double dt = std::max(0.0, t - me.last_t.value_or(t));
  me.last_t = t;
  Impl::Cycle cycle{record, dt, drive, watch};
  core::VelocityCommand wanted;
  try
  {
    wanted = me.run(cycle);
    me.describe(record);
  }
  catch (const std::exception& error)
  {
    wanted = {};
    record.reason = std::string("internal error: ") + error.what() + ": brake";
    cycle.unsafe = record.reason;
    ++me.statistics.dropped["cycle: internal error"];
  }
  catch (...)  // not even an exception: somebody's plain value
  {
    wanted = {};
    record.reason = cycle.unsafe = "internal error: unknown: brake";
    ++me.statistics.dropped["cycle: internal error"];
  }
  try
  {
    me.release(cycle, wanted);
    me.finish(cycle);
  }
  catch (const std::exception& error)  // no memory left
  {
    record.command = me.last_command = {};
    record.reason = error.what();
  }
  catch (...)
  {
    record.command = me.last_command = {};
    record.reason = "internal error: unknown";
  }
  return record;
}

EngineStatus Engine::status() const
{
  return impl_->status;
}

std::optional<core::VehicleState> Engine::state() const
{
  return impl_->last_t ? impl_->source.state(*impl_->last_t) : std::nullopt;
}

const EngineStatistics& Engine::statistics() const
{
  return impl_->statistics;
}

double Engine::referenceLength() const
{
  return impl_->flight ? impl_->flight->length : 0.0;
}

bool Engine::writeOctree(const std::filesystem::path& file)
{
  impl_->pipeline.drain();
  return impl_->pipeline.mapper().writeOctree(file);
}

}  // namespace slalom::engine
