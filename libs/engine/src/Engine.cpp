// SPDX-License-Identifier: BSD-3-Clause
#include "slalom/engine/Engine.h"

#include <algorithm>
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
  }
  return "?";
}

/// The command that the vehicle should fly as far as map, reference and planners know.
core::VelocityCommand Engine::Impl::run(const Cycle& cycle)
{
  core::CycleRecord& record = cycle.record;
  mapPending(record.t);
  const auto state = source.state(record.t);
  if (!state)
  {
    status = EngineStatus::WaitingForState;
    return stop(record, "no state estimate yet (" + source.name() + ")");
  }
  record.state = *state;
  record.has_state = true;
  std::string refusal;
  if (waiting_mission && source.onlyAssumed())
    refusal = "no position source: a mission cannot be flown";
  else if (waiting_mission)
    refusal = startMission(*state);
  if (flight)
  {
    followDrift(*state, cycle.dt);
    takeRefinement(record);
    requestRefinement(*state, record.t);
    takeRefinement(record);  // at once, unless the planner runs in a thread of its own
  }
  const core::VelocityCommand wanted = flight && cycle.drive
                                           ? plan(cycle)
                                           : stop(record, flight            ? "suspended"
                                                          : refusal.empty() ? "no mission"
                                                                            : refusal);
  constexpr double kMeasurable = 0.01;
  record.verified_stop =
      state->v_W.norm() < kAtRest_mps ||
      (record.committed.cols() > 0 && refinements.explanation().stop_excess <= kMeasurable);
  status = flight ? judge.judge(*flight, refinements, onReference(), record, cycle.dt, cycle.drive)
                  : EngineStatus::NoMission;
  return wanted;
}

core::VelocityCommand Engine::Impl::plan(const Cycle& cycle)
{
  core::CycleRecord& record = cycle.record;
  local_planner::LocalPlannerInput input;
  input.state = record.state;
  input.last_command = last_command;
  Hold hold = handOver(
      {config, *flight, refinements, source, currentMap(), record.t, record.state.t}, input);
  if (input.reference)
  {
    clock.advance(cycle.dt, *input.reference, *input.law, input.state.p_L);
    input.progress = clock.progress();
    record.pace = clock.pace();
    record.refined_point_L = input.reference->position(input.progress);
    describePlan(input, 2.0 * config.global_planner.horizon_m / config.vehicle.max_speed_mps,
                 record);
  }
  const Stopwatch watch;
  local_planner::LocalPlannerOutput output = local.step(input);
  record.timing.local = watch.seconds();
  if (record.timing.local > config.rates.local_period_s) ++statistics.late_local;

  const bool held = hold.kind != Hold::Kind::None;
  if (output.fallback == local_planner::Fallback::Shifted) ++statistics.fallback_shifted;
  if (output.fallback == local_planner::Fallback::Brake && !held) ++statistics.fallback_brake;
  record.reason = held ? std::move(hold.reason) : std::move(output.reason);
  describeStep(output, record);
  return output.command;
}

/// Brings a moving command down within the vehicle's limits; without one, stands still.
core::VelocityCommand Engine::Impl::stop(core::CycleRecord& record, std::string reason)
{
  record.reason = std::move(reason);
  if (last_command.v_W.norm() == 0.0 && last_command.yaw_rate == 0.0) return {};
  local_planner::LocalPlannerInput input;
  input.state = record.state;
  input.last_command = last_command;
  return local.step(input).command;
}

/// The one way out: every command of every cycle passes here, whoever decided it.
void Engine::Impl::release(core::CycleRecord& record, const core::VelocityCommand& wanted)
{
  record.command = wanted;
  last_command = record.command;
}

void Engine::Impl::describe(core::CycleRecord& record) const
{
  if (const auto map = pipeline.latestMap())
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

Engine::Engine(const EngineConfig& config)
{
  check(config);
  impl_ = std::make_unique<Impl>(config);
}

Engine::~Engine() = default;

void Engine::setMission(const Mission& mission)
{
  if (mission.waypoints_W.cols() == 0 || !mission.waypoints_W.allFinite())
    throw std::invalid_argument("a mission needs at least one waypoint with finite coordinates");
  clearMission();
  impl_->waiting_mission = mission;
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
  if (const auto* scan = std::get_if<core::RangeScan>(&measurement)) impl_->scans.add(*scan);
  impl_->estimate_s += watch.seconds();
}

core::CycleRecord Engine::step(double t, bool drive)
{
  Impl& me = *impl_;
  const Stopwatch watch;
  core::CycleRecord record;
  record.index = me.statistics.cycles++;
  record.t = t;
  const double dt = std::max(0.0, t - me.last_t.value_or(t));
  me.last_t = t;
  const Impl::Cycle cycle{record, dt, drive, watch};
  core::VelocityCommand wanted;
  try
  {
    wanted = me.run(cycle);
    me.describe(record);
  }
  catch (const std::exception& error)
  {
    wanted = {};
    record.reason = std::string("internal error: ") + error.what() + ": stop";
    ++me.statistics.dropped["cycle: internal error"];
  }
  me.release(record, wanted);
  me.finish(cycle);
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
