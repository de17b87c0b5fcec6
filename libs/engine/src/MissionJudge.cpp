// SPDX-License-Identifier: BSD-3-Clause
#include "MissionJudge.h"

#include <algorithm>

namespace slalom::engine
{
EngineStatus MissionJudge::judge(Flight& flight, const Refinements& refinements,
                                 double on_reference, const core::CycleRecord& record, double dt,
                                 bool could_go)
{
  using global_planner::GoalPolicy;
  constexpr double kEndOfR_s = 2.0;
  const GoalPolicy policy = config_.global_planner.goal_policy;
  const Eigen::Vector3d& p_L = record.state.p_L;
  const double tolerance = config_.mission.goal_tolerance_m;
  const Eigen::Vector3d goal_L = flight.reference_L->position(flight.reference_L->end());
  // Near the goal, and at the end of R: a mission may pass its goal, or begin there.
  const bool at_end = on_reference >= flight.reference_L->end() - kEndOfR_s;
  flight.reached = flight.reached || (at_end && (p_L - goal_L).norm() <= tolerance);
  const bool rests = record.state.v_W.norm() < kAtRest_mps;
  const auto& refined = refinements.refined();
  const bool holds = rests && refinements.outcome() == global_planner::RefineOutcome::GoalBlocked &&
                     refined &&
                     (refinements.rejectsGoal(policy) ||
                      (p_L - refined->spline.position(refined->stop_at)).norm() <= tolerance);
  const bool near_enough = policy == GoalPolicy::NearestFree &&
                           (p_L - goal_L).norm() <= config_.global_planner.goal_radius_m;
  flight.reached = flight.reached || (holds && near_enough);
  standing_s_ = rests && could_go && !holds && !flight.reached ? standing_s_ + dt : 0.0;
  // What counts is how far along R the vehicle itself has come, not its plans.
  constexpr double kProgress_s = 0.5;  // less is going back and forth
  constexpr double kWindow_s = 3.0;    // not to take a later leg that passes nearby for progress
  const spline::UniformBSpline& r = *flight.reference_L;
  farthest_ = std::max(farthest_, r.start());
  const double nearest = r.project(p_L, farthest_, std::min(r.end(), farthest_ + kWindow_s));
  if (nearest > farthest_ + kProgress_s)
  {
    farthest_ = nearest;
    wandering_s_ = 0.0;
  }
  if (could_go && !holds) wandering_s_ += dt;
  if (flight.reached) return EngineStatus::GoalReached;
  if (holds) return EngineStatus::GoalBlocked;
  return standing_s_ > config_.mission.blocked_timeout_s ||
                 wandering_s_ > config_.mission.progress_timeout_s
             ? EngineStatus::Unreachable
             : EngineStatus::Navigating;
}

}  // namespace slalom::engine
