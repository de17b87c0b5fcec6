// SPDX-License-Identifier: BSD-3-Clause
#include "slalom/engine/Engine.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

#include "DecisionHash.h"
#include "Flight.h"
#include "Pipeline.h"
#include "ReferenceClock.h"
#include "ScanAssembler.h"
#include "StateSource.h"
#include "Stopwatch.h"
#include "slalom/local_planner/LocalPlanner.h"

namespace slalom::engine
{
namespace
{
using global_planner::GoalPolicy;
using global_planner::RefinedReference;
using global_planner::RefineOutcome;
using spline::UniformBSpline;

constexpr double kEndOfR_s = 2.0;
constexpr double kAtRest_mps = 0.1;

Eigen::Matrix3Xd samplePath(const UniformBSpline& curve, double from, double to, double step_s)
{
  return curve.sample(from, to, std::max<Eigen::Index>(2, Eigen::Index((to - from) / step_s) + 1));
}

}  // namespace

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

struct Engine::Impl
{
  explicit Impl(const EngineConfig& c)
      : config(c),
        source(c.state, c.estimation),
        pipeline(c),
        local(c.local_planner, c.vehicle),
        clock(c.mission.max_lead_s)
  {
  }

  [[nodiscard]] std::shared_ptr<const MapResult> currentMap() const;
  void beginNewFrame();
  void mapPending(double t);
  [[nodiscard]] std::string startMission(const core::VehicleState& state);
  void followDrift(const core::VehicleState& state, double dt);
  void requestRefinement(const core::VehicleState& state, double t);
  void takeRefinement(core::CycleRecord& record);
  void run(core::CycleRecord& record, double dt, bool drive);
  void stop(core::CycleRecord& record, std::string reason);
  void plan(core::CycleRecord& record, double dt);
  [[nodiscard]] double onReference() const;
  void judge(const core::CycleRecord& record, double dt, bool drive);
  [[nodiscard]] bool rejectsGoal() const;
  void describe(core::CycleRecord& record) const;
  void finish(core::CycleRecord& record, const Stopwatch& watch);

  EngineConfig config;
  StateSource source;
  ScanAssembler scans;
  Pipeline pipeline;
  local_planner::LocalPlanner local;
  ReferenceClock clock;
  EngineStatistics statistics;
  EngineStatus status = EngineStatus::WaitingForState;

  std::optional<Mission> waiting_mission;
  std::optional<Flight> flight;
  std::uint64_t missions = 0;
  std::shared_ptr<const RefinedReference> refined;
  RefineOutcome outcome = RefineOutcome::NoField;
  global_planner::GoalReport goal;
  core::RefinementRecord explanation;
  double standing_s = 0.0;  // how long the vehicle has stood although the mission is not over

  std::uint64_t seen_epoch = 0;
  bool forget_map = false;
  std::uint64_t void_map = 0;  // maps up to this one belong to an old frame
  bool waiting_refinement = false;
  std::uint64_t seen_map = 0, refined_map = 0, seen_refinement = 0;
  double last_refine_t = -std::numeric_limits<double>::infinity();
  std::optional<double> last_t;
  core::VelocityCommand last_command;
  DecisionHash hash;
  double estimate_s = 0.0;  // wall time of add() since the last cycle
};

/// The newest map of the present local frame.
std::shared_ptr<const MapResult> Engine::Impl::currentMap() const
{
  auto map = pipeline.latestMap();
  return map && map->count > void_map ? map : nullptr;
}

/// The local frame began anew: whatever was expressed in the old one is void.
void Engine::Impl::beginNewFrame()
{
  forget_map = true;
  if (const auto map = pipeline.latestMap()) void_map = map->count;
  if (flight) flight->number = ++missions;  // refinements under way belong to the old frame
  waiting_refinement = false;
  if (refined) clock.restart(refined->referenceTime(clock.progress()));
  refined.reset();
  local.reset();
  if (const auto state = source.state(source.newest()); state && flight)
    flight->moveTo(state->p_L - state->p_W);
}

void Engine::Impl::mapPending(double t)
{
  if (std::exchange(seen_epoch, source.frameEpoch()) != source.frameEpoch()) beginNewFrame();
  for (MapJob& job : scans.take(source, t, statistics.dropped))
  {
    job.forget = std::exchange(forget_map, false);
    ++statistics.scans;
    if (const std::size_t lost = pipeline.map(std::move(job)))
    {
      statistics.dropped["scan: mapper late"] += lost;
      statistics.late_map += lost;
    }
  }
}

/// Empty, or why the mission cannot be flown.
std::string Engine::Impl::startMission(const core::VehicleState& state)
{
  const Mission mission = *std::exchange(waiting_mission, std::nullopt);
  refined.reset();
  outcome = RefineOutcome::NoField;
  goal = {};
  standing_s = 0.0;
  explanation = {};
  last_refine_t = -std::numeric_limits<double>::infinity();
  waiting_refinement = false;
  refined_map = 0;
  local.reset();
  try
  {
    Flight next(++missions, fitReference(mission, state, config), state.p_L - state.p_W,
                config.planned());
    clock.restart(next.reference_L->start());
    flight = std::move(next);
  }
  catch (const std::invalid_argument& error)
  {
    return std::string("mission refused: ") + error.what();
  }
  return {};
}

void Engine::Impl::followDrift(const core::VehicleState& state, double dt)
{
  const Eigen::Vector3d missing = (state.p_L - state.p_W) - flight->offset;
  const double allowed = config.state.anchor_rate_mps * dt;
  if (missing.norm() < 1e-9 || allowed <= 0.0) return;
  flight->moveTo(flight->offset + missing * std::min(1.0, allowed / missing.norm()));
}

/// One request at a time: the next one continues the plan that comes of this one.
void Engine::Impl::requestRefinement(const core::VehicleState& state, double t)
{
  constexpr double kLost_s = 1.0;  // a step that threw never answers
  if (waiting_refinement && t - last_refine_t < kLost_s) return;
  const auto map = currentMap();
  if (!map || map->count == refined_map || t - last_refine_t < config.rates.global_period_s - 1e-6)
    return;
  refined_map = map->count;
  last_refine_t = t;
  waiting_refinement = true;
  GlobalJob job{flight->number,
                {flight->reference_L,
                 refined,
                 map->field,
                 state,
                 clock.progress(),
                 clock.pace(),
                 flight->offset.z(),
                 {}}};
  if (pipeline.refine(std::move(job)) > 0) ++statistics.late_global;
}

void Engine::Impl::takeRefinement(core::CycleRecord& record)
{
  const auto result = pipeline.latestRefinement();
  if (!result || result->count == seen_refinement) return;
  seen_refinement = result->count;
  if (!flight || result->mission != flight->number) return;
  waiting_refinement = false;
  refined = result->output.refined;
  outcome = result->output.outcome;
  goal = result->output.goal;
  explanation = result->output.record;
  record.refinement.ran = true;
  record.timing.global = result->wall_s;
  ++statistics.replans;
  const bool failed = outcome == RefineOutcome::GuideFailed ||
                      outcome == RefineOutcome::StillOccupied || outcome == RefineOutcome::NoField;
  ++(failed ? statistics.refined_failed : statistics.refined_ok);
  if (outcome == RefineOutcome::Recovered) ++statistics.recoveries;
  if (result->wall_s > config.rates.global_period_s) ++statistics.late_global;
}

void Engine::Impl::plan(core::CycleRecord& record, double dt)
{
  const auto map = currentMap();
  const bool map_is_fresh = map && record.t - map->field->stamp() <= config.rates.map_timeout_s;
  local_planner::LocalPlannerInput input;
  input.state = record.state;
  input.last_command = last_command;
  std::string brake;
  if (flight->reached)
    brake = "goal reached: hold";
  else if (rejectsGoal())
    brake = "goal occupied: rejected";
  else if (source.deadReckoning())
    brake = "neither position nor velocity for too long: brake";
  else if (record.t - record.state.t > config.rates.state_timeout_s)
    brake = "state too old: brake";
  else if (map_is_fresh && refined)
  {
    input.field = map->field;
    input.reference = {refined, &refined->spline};
    input.law = {refined, &refined->law};
  }
  else if (!map && !config.rates.require_map)
  {
    input.reference = flight->reference_L;
    input.law = flight->law;
  }
  else
    brake = !map           ? "no map yet: brake"
            : map_is_fresh ? "no refined reference yet: brake"
                           : "map too old: brake";

  if (input.reference)
  {
    clock.advance(dt, *input.reference, *input.law, input.state.p_L);
    input.progress = clock.progress();
    record.pace = clock.pace();
    record.refined_point_L = input.reference->position(input.progress);
    const double ahead = config.global_planner.horizon_m / config.vehicle.max_speed_mps;
    record.refined =
        samplePath(*input.reference, input.progress,
                   std::min(input.reference->end(), input.progress + 2.0 * ahead), 0.1);
    record.committed = samplePath(*input.reference, input.progress, input.law->to(), 0.1);
  }
  const Stopwatch watch;
  local_planner::LocalPlannerOutput output = local.step(input);
  record.timing.local = watch.seconds();
  if (record.timing.local > config.rates.local_period_s) ++statistics.late_local;

  record.command = output.command;
  record.horizon = std::move(output.horizon_L);
  record.horizon_yaw = std::move(output.horizon_yaw);
  record.nmpc = std::move(output.report);
  if (output.fallback != local_planner::Fallback::None) record.fallback = toString(output.fallback);
  if (output.fallback == local_planner::Fallback::Shifted) ++statistics.fallback_shifted;
  if (output.fallback == local_planner::Fallback::Brake && brake.empty())
    ++statistics.fallback_brake;
  record.reason = brake.empty() ? std::move(output.reason) : std::move(brake);
  if (record.horizon.cols() > 1)
  {
    record.setpoint_L = record.horizon.col(1);
    record.setpoint_yaw = record.horizon_yaw[1];
  }
}

/// Parameter of R that the vehicle has come to [s].
double Engine::Impl::onReference() const
{
  return refined ? refined->referenceTime(clock.progress()) : clock.progress();
}

void Engine::Impl::judge(const core::CycleRecord& record, double dt, bool drive)
{
  if (!flight)
  {
    status = EngineStatus::NoMission;
    return;
  }
  const Eigen::Vector3d goal_L = flight->reference_L->position(flight->reference_L->end());
  // Near the goal, and at the end of R: a mission may pass its goal, or begin there.
  const bool at_end = onReference() >= flight->reference_L->end() - kEndOfR_s;
  flight->reached = flight->reached || (at_end && (record.state.p_L - goal_L).norm() <=
                                                      config.mission.goal_tolerance_m);
  const bool rests = record.state.v_W.norm() < kAtRest_mps;
  const bool holds =
      rests && outcome == RefineOutcome::GoalBlocked && refined &&
      (rejectsGoal() || (record.state.p_L - refined->spline.position(refined->stop_at)).norm() <=
                            config.mission.goal_tolerance_m);
  const bool near_enough =
      config.global_planner.goal_policy == GoalPolicy::NearestFree &&
      (record.state.p_L - goal_L).norm() <= config.global_planner.goal_radius_m;
  flight->reached = flight->reached || (holds && near_enough);
  const bool could_go = drive && record.refined.cols() > 0;
  standing_s = rests && could_go && !holds && !flight->reached ? standing_s + dt : 0.0;
  status = flight->reached                                 ? EngineStatus::GoalReached
           : holds                                         ? EngineStatus::GoalBlocked
           : standing_s > config.mission.blocked_timeout_s ? EngineStatus::Unreachable
                                                           : EngineStatus::Navigating;
}

bool Engine::Impl::rejectsGoal() const
{
  return config.global_planner.goal_policy == GoalPolicy::Reject &&
         outcome == RefineOutcome::GoalBlocked && goal.state == global_planner::GoalState::Occupied;
}

void Engine::Impl::describe(core::CycleRecord& record) const
{
  if (const auto map = pipeline.latestMap())
  {
    record.field = map->field;
    record.map_sequence = map->field->sequence();
  }
  if (flight)
  {
    const UniformBSpline& r = *flight->reference_L;
    record.reference = samplePath(r, r.start(), r.end(), 0.2);
    record.progress_s = onReference();
    record.reference_point_L = r.position(record.progress_s);
    record.distance_to_goal_m = (record.state.p_L - r.position(r.end())).norm();
    const bool ran = record.refinement.ran;
    record.refinement = explanation;
    record.refinement.ran = ran;
    record.refinement.goal = toString(goal.state);
    record.refinement.goal_short_m = goal.short_m;
  }
  if (refined) record.reference_sequence = refined->sequence;
  record.origin_offset_norm_m = (record.state.p_L - record.state.p_W).norm();
}

void Engine::Impl::finish(core::CycleRecord& record, const Stopwatch& watch)
{
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
  record.timing.cycle = watch.seconds() + record.timing.estimate;
  last_command = record.command;
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
  impl_->refined.reset();
  if (impl_->status != EngineStatus::WaitingForState) impl_->status = EngineStatus::NoMission;
}

void Engine::add(const core::Measurement& measurement)
{
  const Stopwatch watch;
  impl_->source.add(measurement);
  if (const auto* scan = std::get_if<core::RangeScan>(&measurement)) impl_->scans.add(*scan);
  impl_->estimate_s += watch.seconds();
}

void Engine::Impl::run(core::CycleRecord& record, double dt, bool drive)
{
  mapPending(record.t);
  const auto state = source.state(record.t);
  if (!state)
  {
    status = EngineStatus::WaitingForState;
    stop(record, "no state estimate yet (" + source.name() + ")");
    return;
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
    followDrift(*state, dt);
    takeRefinement(record);
    requestRefinement(*state, record.t);
    takeRefinement(record);  // at once, unless the planner runs in a thread of its own
  }
  if (flight && drive)
    plan(record, dt);
  else
    stop(record, flight ? "suspended" : refusal.empty() ? "no mission" : refusal);
  constexpr double kMeasurable = 0.01;
  record.verified_stop = state->v_W.norm() < kAtRest_mps ||
                         (record.committed.cols() > 0 && explanation.stop_excess <= kMeasurable);
  judge(record, dt, drive);
}

/// Brings a moving command down within the vehicle's limits; without one, stands still.
void Engine::Impl::stop(core::CycleRecord& record, std::string reason)
{
  record.reason = std::move(reason);
  if (last_command.v_W.norm() == 0.0 && last_command.yaw_rate == 0.0) return;
  local_planner::LocalPlannerInput input;
  input.state = record.state;
  input.last_command = last_command;
  record.command = local.step(input).command;
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
  try
  {
    me.run(record, dt, drive);
    me.describe(record);
  }
  catch (const std::exception& error)
  {
    record.command = {};
    record.reason = std::string("internal error: ") + error.what() + ": stop";
    ++me.statistics.dropped["cycle: internal error"];
  }
  me.finish(record, watch);
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
