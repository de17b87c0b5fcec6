// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>
#include <string_view>

#include "slalom/core/CycleRecord.h"
#include "slalom/core/Deadline.h"
#include "slalom/core/DistanceField.h"
#include "slalom/core/Vehicle.h"
#include "slalom/core/VehicleState.h"
#include "slalom/global_planner/GlobalPlannerConfig.h"
#include "slalom/global_planner/RefinedReference.h"
#include "slalom/spline/UniformBSpline.h"

namespace slalom::global_planner
{
enum class RefineOutcome
{
  Clear,        ///< no occupied segment in the window; J was still minimised (Algorithm 1)
  Refined,      ///< pushed around obstacles, verified clear
  Recovered,    ///< the pushing problem failed, dead-zone recovery [Paper Eq. (5)] gave a verified
                ///< result
  GuideFailed,  ///< no way around found; the previous reference is kept
  StillOccupied,  ///< optimised but not clear; the previous reference is kept
  GoalBlocked,    ///< the end of R lies in an obstacle; the refined reference ends at the last
                  ///< reachable point
  NoField         ///< no map yet; the previous reference is kept
};
[[nodiscard]] std::string_view toString(RefineOutcome outcome);

/// What the newest map says about the end of R.
enum class GoalState
{
  NotSeen,  ///< beyond the map
  Free,
  Unknown,     ///< inside the map, never seen
  Occupied,    ///< an obstacle is nearer than the hard clearance: the radius and its margins
  Unreachable  ///< free, but nothing leads there
};
[[nodiscard]] std::string_view toString(GoalState state);

struct GoalReport
{
  GoalState state = GoalState::NotSeen;
  Eigen::Vector3d nearest_L = Eigen::Vector3d::Zero();  ///< where the vehicle will rest [m]
  double short_m = 0.0;                                 ///< distance from there to the end of R
};

struct GlobalPlannerInput
{
  std::shared_ptr<const spline::UniformBSpline> reference;  ///< immutable R, local frame
  std::shared_ptr<const RefinedReference> previous;         ///< warm start; null at first
  std::shared_ptr<const core::DistanceField> field;         ///< one map for the whole step
  core::VehicleState state;
  double progress = 0.0;   ///< [s] parameter of the vehicle on `previous`; on R when there is none
  double pace = 1.0;       ///< [1] how fast that parameter runs at present
  bool only_goal = false;  ///< R is a straight line to a goal, which nobody asked for itself
  double altitude_offset =
      0.0;  ///< [m] local minus world altitude; altitude limits are the world's
  core::Deadline deadline = core::Deadline::none();
};

struct GlobalPlannerOutput
{
  RefineOutcome outcome = RefineOutcome::NoField;
  GoalReport goal;
  std::shared_ptr<const RefinedReference>
      refined;  ///< `previous` without a field, which may be null; never null otherwise
  core::RefinementRecord record;  ///< explains the outcome
};

/** One step of the global planner [Paper Algorithm 1, global part]: window of R ahead of the
 * vehicle -> occupied segments -> guides -> parallel convex decomposition -> pushing directions ->
 * gradients -> J -> certificate -> time law.
 *
 *  A pure function of its input (no warm start of its own). A plan is committed only with a proof
 * that its whole curve keeps the vehicle's radius from every known obstacle, and a time law that
 * rests before anything that is not known to be free. Without one the previous plan stays, cut
 * before what blocks it. The span under the vehicle keeps its control points, so position, velocity
 * and acceleration are continuous there, unless the plan starts anew at the vehicle (far from the
 * old one, or at rest before a blockage).
 *  @see docs/paper_map.md for each equation's home */
class GlobalPlanner
{
 public:
  /// @throws std::invalid_argument when config and vehicle contradict each other (clearance below
  /// the radius, ...)
  GlobalPlanner(const GlobalPlannerConfig& config, const core::Vehicle& vehicle);

  [[nodiscard]] GlobalPlannerOutput step(const GlobalPlannerInput& input) const;

 private:
  GlobalPlannerConfig config_;
  core::Vehicle vehicle_;
};

}  // namespace slalom::global_planner
