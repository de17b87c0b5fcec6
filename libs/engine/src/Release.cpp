// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "EngineImpl.h"

namespace slalom::engine
{
namespace
{
constexpr double kStopStep_s = 0.05;
constexpr double kLongestStop_s = 15.0;
}  // namespace

/// The rest of the plan in force, from where its clock stands, down to rest.
safety::StopPath Engine::Impl::plannedStop() const
{
  safety::StopPath path;
  path.step_s = kStopStep_s;
  path.begins_s = config.vehicle.command_delay_s;  // the clock lives at the time of effect
  const auto& refined = refinements.refined();
  if (!refined) return path;
  const spline::TimeLaw& law = refined->law;
  double parameter = std::clamp(clock.progress(), law.from(), law.to());
  for (double tau = 0.0; tau < kLongestStop_s && parameter < law.to(); tau += kStopStep_s)
  {
    path.p_L.push_back(refined->spline.position(parameter));
    path.v_L.push_back(law.pace(parameter) * refined->spline.velocity(parameter));
    parameter = law.advance(parameter, kStopStep_s);
  }
  path.p_L.push_back(refined->spline.position(parameter));
  path.v_L.push_back(Eigen::Vector3d::Zero());
  return path;
}

/// The plan that the last command relied on, as seen from now.
void Engine::Impl::ageReliedStop(double dt)
{
  relied_stop.begins_s -= dt;
  const double length_s = kStopStep_s * static_cast<double>(relied_stop.p_L.size());
  if (relied_stop.begins_s < -length_s) relied_stop = {};
}

/** The one way out: every command of every cycle passes here, whoever decided it, and the output
 * gate has the last word. */
void Engine::Impl::release(Cycle& cycle, const core::VelocityCommand& wanted)
{
  core::CycleRecord& record = cycle.record;
  const auto map = currentMap();
  const safety::StopPath planned = plannedStop();
  ageReliedStop(cycle.dt);

  constexpr double kNever = std::numeric_limits<double>::infinity();
  safety::GateInput input;
  input.t = record.t;
  input.state = cycle.ahead;
  input.state_age_s = record.has_state ? std::abs(record.t - source.newest()) : kNever;
  input.map_age_s = map ? record.t - map->field->stamp() : kNever;
  input.plan_age_s = refinements.refined() ? refinements.age(record.t) : kNever;
  input.needs_map = config.rates.require_map || pipeline.latestMap();
  if (map) input.field = map->field;
  input.movers = record.movers;
  input.wanted = wanted;
  input.last = last_command;
  input.dt = sinceLastCommand(cycle);
  input.hold_s = config.rates.local_period_s;
  if (!planned.p_L.empty()) input.plan = &planned;
  if (!relied_stop.p_L.empty()) input.kept_plan = &relied_stop;
  input.kept_evasion = relied_evasion;
  input.may_evade = flight && cycle.drive;
  const bool walked_into = input.may_evade && !input.movers.empty();
  const bool stands = !walked_into && wanted.v_W.isZero() && wanted.yaw_rate == 0.0 &&
                      last_command.v_W.isZero() && last_command.yaw_rate == 0.0;
  const safety::GateOutput output = stands ? safety::GateOutput{} : gate.pass(input);

  if (output.stop_plan == &planned) relied_stop = planned;
  relied_evasion = output.evasion;
  record.command = output.command;
  record.gate.stop_margin_m = output.stop_margin_m;
  if (output.intervention != safety::Intervention::None)
  {
    record.gate.intervention = toString(output.intervention);
    ++statistics.gate[record.gate.intervention];
  }
  if (output.intervention != safety::Intervention::Limits && !output.reason.empty())
  {
    if (cycle.unsafe.empty()) cycle.unsafe = output.reason;
    record.reason += "; gate: " + output.reason;
  }
  last_command = record.command;
  if (flight && cycle.drive && !config.rates.open_loop)
    predictor.sent(record.t, record.command);
  else
    predictor.forget();  // without a mission, or suspended, the vehicle is somebody else's
}

}  // namespace slalom::engine
