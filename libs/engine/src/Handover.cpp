// SPDX-License-Identifier: BSD-3-Clause
#include "Handover.h"

namespace slalom::engine
{
Hold handOver(const Situation& now, local_planner::LocalPlannerInput& input)
{
  using Kind = Hold::Kind;
  const RateConfig& rates = now.config.rates;
  const safety::SafetyConfig& safety = now.config.safety;
  if (now.flight.reached) return {Kind::Wanted, "goal reached: hold"};
  if (now.blocked && !rates.open_loop) return {Kind::Wanted, "goal blocked: hold"};
  if (now.refinements.rejectsGoal(now.config.global_planner.goal_policy))
    return {Kind::Wanted, "goal occupied: rejected"};
  if (now.source.deadReckoning())
    return {Kind::Safety, "neither position nor velocity for too long: brake"};
  if (now.source.newest() - now.t > safety.state_timeout_s)
    return {Kind::Safety, "the state is dated ahead of the clock: brake"};
  if (now.t - now.state_t > safety.state_timeout_s) return {Kind::Safety, "state too old: brake"};

  if (now.stuck) return {Kind::Safety, "the position does not follow the commands: brake"};

  if (!now.slow.empty()) return {Kind::Safety, now.slow + ": brake"};

  const auto& refined = now.refinements.refined();
  const bool map_is_fresh = now.map && now.t - now.map->field->stamp() <= safety.map_timeout_s;
  if (map_is_fresh && refined)
  {
    input.field = now.map->field;
    input.reference = {refined, &refined->spline};
    input.law = {refined, &refined->law};
    return {};
  }
  if (!now.mapped && !rates.require_map)
  {
    input.reference = now.flight.reference_L;
    input.law = now.flight.law;
    return {};
  }
  if (!now.map) return {Kind::Waiting, "no map yet: brake"};
  if (map_is_fresh) return {Kind::Waiting, "no refined reference yet: brake"};
  return {Kind::Safety, now.refused ? "the scans contradict the map: brake" : "map too old: brake"};
}

}  // namespace slalom::engine
