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

/// R after refinement: the same knots as R, other control points inside the window. Immutable,
/// shared between planners.
struct RefinedReference
{
  spline::UniformBSpline spline;
  double clear_until =
      0.0;  ///< [s] parameter up to which the curve was verified clear (optimistic field)
  double stop_at =
      0.0;  ///< [s] parameter at which the vehicle must rest: end of R, or of what was verified
  std::uint64_t sequence = 0;  ///< counts commits
  std::uint64_t map_sequence = 0;
};

struct GlobalPlannerInput
{
  std::shared_ptr<const spline::UniformBSpline> reference;  ///< immutable R, local frame
  std::shared_ptr<const RefinedReference> previous;         ///< warm start; null at first
  std::shared_ptr<const core::DistanceField> field;         ///< one map for the whole step
  core::VehicleState state;
  double progress = 0.0;  ///< [s] parameter on R of the vehicle
  double altitude_offset =
      0.0;  ///< [m] local minus world altitude; altitude limits are the world's
  core::Deadline deadline = core::Deadline::none();
};

struct GlobalPlannerOutput
{
  RefineOutcome outcome = RefineOutcome::NoField;
  std::shared_ptr<const RefinedReference>
      refined;  ///< never null: `previous`, or R itself, when nothing better is proved
  core::RefinementRecord record;  ///< explains the outcome
};

/** One step of the global planner [Paper Algorithm 1, global part]: window of R ahead of the
 * vehicle -> occupied segments -> guide -> parallel convex decomposition -> pushing directions ->
 * gradients -> J by L-BFGS-B -> check.
 *
 *  A pure function of its input (no warm start of its own). A refinement that is not verified clear
 * is never applied silently. The control points of the span under the vehicle are those of
 * `previous`, so position, velocity and acceleration are continuous where the vehicle is, unless it
 * starts a new plan where it stands (far from the old one, or at rest before a blockage).
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
