// SPDX-License-Identifier: BSD-3-Clause
#include "Refinements.h"

namespace slalom::engine
{
using global_planner::RefineOutcome;

bool Refinements::due(const MapResult& map, double t) const
{
  constexpr double kLost_s = 1.0;  // a step that threw never answers
  if (waiting_ && t - asked_t_ < kLost_s) return false;
  return map.count != asked_map_ && t - asked_t_ >= period_s_ - 1e-6;
}

void Refinements::asked(const MapResult& map, double t)
{
  if (!waiting_) waiting_since_ = t;
  asked_map_ = map.count;
  asked_t_ = t;
  waiting_ = true;
}

std::shared_ptr<const GlobalResult> Refinements::take(const Pipeline& pipeline,
                                                      std::uint64_t mission)
{
  const auto result = pipeline.latestRefinement();
  if (!result || result->count == seen_) return nullptr;
  seen_ = result->count;
  if (result->mission != mission) return nullptr;
  waiting_ = false;
  answered_t_ = result->t;
  refined_ = result->output.refined;
  outcome_ = result->output.outcome;
  goal_ = result->output.goal;
  explanation_ = result->output.record;
  return result;
}

bool Refinements::rejectsGoal(global_planner::GoalPolicy policy) const
{
  return policy == global_planner::GoalPolicy::Reject && outcome_ == RefineOutcome::GoalBlocked &&
         goal_.state == global_planner::GoalState::Occupied;
}

bool Refinements::failed() const
{
  return outcome_ == RefineOutcome::GuideFailed || outcome_ == RefineOutcome::StillOccupied ||
         outcome_ == RefineOutcome::NoField;
}

}  // namespace slalom::engine
