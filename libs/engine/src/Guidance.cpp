// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <stdexcept>
#include <utility>

#include "EngineImpl.h"

namespace slalom::engine
{
/// Empty, or why the mission cannot be flown.
std::string Engine::Impl::startMission(const core::VehicleState& state)
{
  const Mission mission = *std::exchange(waiting_mission, std::nullopt);
  refinements.restart();
  judge.restart();
  local.reset();
  due.clear();
  try
  {
    Flight next(++missions, fitReference(mission, state, config), state.p_L - state.p_W,
                config.planned(), !config.rates.require_map);
    next.only_goal = mission.waypoints_W.cols() == 1;
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

void Engine::Impl::requestRefinement(const core::VehicleState& state, double t)
{
  const auto map = currentMap();
  if (!map || !refinements.due(*map, t)) return;
  refinements.asked(*map, t);
  GlobalJob job{flight->number,
                t,
                {flight->reference_L,
                 refinements.refined(),
                 map->field,
                 state,
                 clock.progress(),
                 clock.pace(),
                 flight->only_goal,
                 flight->offset.z(),
                 {}}};
  if (pipeline.refine(std::move(job)) > 0) ++statistics.late_global;
}

void Engine::Impl::takeRefinement(core::CycleRecord& record)
{
  const auto result = refinements.take(pipeline, flight->number);
  if (!result) return;
  record.refinement.ran = true;
  record.timing.global = result->wall_s;
  ++statistics.replans;
  ++(refinements.failed() ? statistics.refined_failed : statistics.refined_ok);
  if (refinements.outcome() == global_planner::RefineOutcome::Recovered) ++statistics.recoveries;
  if (result->wall_s > config.rates.global_period_s) ++statistics.late_global;
}

/// Parameter of R that the vehicle has come to [s].
double Engine::Impl::onReference() const
{
  const auto& refined = refinements.refined();
  return refined ? refined->referenceTime(clock.progress()) : clock.progress();
}

}  // namespace slalom::engine
