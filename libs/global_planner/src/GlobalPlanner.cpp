// SPDX-License-Identifier: BSD-3-Clause
#include "slalom/global_planner/GlobalPlanner.h"

#include <algorithm>
#include <stdexcept>
#include <string>

#include "PlanStep.h"

namespace slalom::global_planner
{
std::string_view toString(RefineOutcome outcome)
{
  switch (outcome)
  {
    case RefineOutcome::Clear:
      return "Clear";
    case RefineOutcome::Refined:
      return "Refined";
    case RefineOutcome::Recovered:
      return "Recovered";
    case RefineOutcome::GuideFailed:
      return "GuideFailed";
    case RefineOutcome::StillOccupied:
      return "StillOccupied";
    case RefineOutcome::GoalBlocked:
      return "GoalBlocked";
    case RefineOutcome::NoField:
      return "NoField";
  }
  return "?";
}

std::string_view toString(GoalState state)
{
  switch (state)
  {
    case GoalState::NotSeen:
      return "not seen";
    case GoalState::Free:
      return "free";
    case GoalState::Unknown:
      return "unknown";
    case GoalState::Occupied:
      return "occupied";
    case GoalState::Unreachable:
      return "unreachable";
  }
  return "?";
}

double RefinedReference::referenceTime(double t) const
{
  const double at = std::clamp((t - spline.start()) / spline.knotSpan() + 1.0, 0.0,
                               static_cast<double>(along.size() - 1));
  const auto k = std::min<Eigen::Index>(static_cast<Eigen::Index>(at), along.size() - 2);
  const double u = at - static_cast<double>(k);
  return (1.0 - u) * along[k] + u * along[k + 1];
}

GlobalPlanner::GlobalPlanner(const GlobalPlannerConfig& config, const core::Vehicle& vehicle)
    : config_(config), vehicle_(vehicle)
{
  if (config.clearance_m <= vehicle.radius_m + config.margin_m)
    throw std::invalid_argument(
        "global_planner.clearance_m = " + std::to_string(config.clearance_m) +
        " must exceed vehicle.radius_m + margin_m = " +
        std::to_string(vehicle.radius_m + config.margin_m));
  if (config.min_altitude_m >= config.max_altitude_m)
    throw std::invalid_argument(
        "global_planner.min_altitude_m = " + std::to_string(config.min_altitude_m) +
        " must be below max_altitude_m = " + std::to_string(config.max_altitude_m));
}

GlobalPlannerOutput GlobalPlanner::step(const GlobalPlannerInput& input) const
{
  if (input.field) return PlanStep(config_, vehicle_, input).run();
  GlobalPlannerOutput output;
  output.refined = input.previous;
  output.record.ran = true;
  output.record.outcome = toString(RefineOutcome::NoField);
  return output;
}

}  // namespace slalom::global_planner
