// SPDX-License-Identifier: BSD-3-Clause
#include "MissionJudge.h"

#include <algorithm>

namespace slalom::engine
{
using global_planner::GoalPolicy;
using global_planner::RefineOutcome;

/// At rest where the plan ends, which is as near to a goal that is blocked as it leads.
bool MissionJudge::holdsBefore(const Refinements& refinements, const Eigen::Vector3d& p_L,
                               bool rests) const
{
  const auto& refined = refinements.refined();
  if (!rests || !refined || refinements.outcome() != RefineOutcome::GoalBlocked) return false;
  return (p_L - refined->spline.position(refined->stop_at)).norm() <=
         config_.mission.goal_tolerance_m;
}

/** Plans around a goal that is blocked change with every map, and a vehicle that followed them all
 * would neither rest nor arrive. So the verdict is given once, when the vehicle has held for a
 * second, if with interruptions, or gains nothing any more; it is taken back only when plans lead
 * to the goal again and again. */
void MissionJudge::judgeBlockage(const Refinements& refinements, bool holds, double distance_m,
                                 double dt, bool could_go)
{
  constexpr double kHeld_s = 1.0, kSure_s = 2.0;
  constexpr double kNearer_m = 0.25;
  constexpr double kFade = 0.1;  // [1] of the time that the vehicle moves on
  const RefineOutcome outcome = refinements.outcome();
  const bool leads = outcome == RefineOutcome::Clear || outcome == RefineOutcome::Refined ||
                     outcome == RefineOutcome::Recovered;
  leading_s_ = leads ? leading_s_ + dt : 0.0;
  if (leading_s_ > kSure_s) return forgetBlockage();
  held_s_ = std::max(0.0, held_s_ + (holds ? dt : -kFade * dt));
  if (distance_m < nearest_m_ - kNearer_m)
  {
    nearest_m_ = distance_m;
    held_s_ = hopeless_s_ = 0.0;
  }
  // Only the planner can say that it is the goal that is blocked.
  const bool its_goal = hopeless_s_ > 0.0 || outcome == RefineOutcome::GoalBlocked;
  if (its_goal && could_go) hopeless_s_ += dt;
  blocked_ = blocked_ || held_s_ > kHeld_s || hopeless_s_ > config_.mission.blocked_timeout_s;
}

EngineStatus MissionJudge::judge(Flight& flight, const Refinements& refinements,
                                 double on_reference, const core::CycleRecord& record, double dt,
                                 bool could_go)
{
  constexpr double kEndOfR_s = 2.0;
  const GoalPolicy policy = config_.global_planner.goal_policy;
  const Eigen::Vector3d& p_L = record.state.p_L;
  const double tolerance = config_.mission.goal_tolerance_m;
  const Eigen::Vector3d goal_L = flight.reference_L->position(flight.reference_L->end());
  // Near the goal, and at the end of R: a mission may pass its goal, or begin there.
  const bool at_end = on_reference >= flight.reference_L->end() - kEndOfR_s;
  flight.reached = flight.reached || (at_end && (p_L - goal_L).norm() <= tolerance);
  const bool rests = record.state.v_W.norm() < kAtRest_mps;
  judgeBlockage(refinements, holdsBefore(refinements, p_L, rests), (p_L - goal_L).norm(), dt,
                could_go);
  const bool holds = blocked_ || (rests && refinements.rejectsGoal(policy));
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
