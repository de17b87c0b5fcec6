// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "Draft.h"
#include "slalom/core/CycleRecord.h"
#include "slalom/core/Deadline.h"
#include "slalom/core/Vehicle.h"
#include "slalom/global_planner/Certificate.h"
#include "slalom/global_planner/GlobalPlannerConfig.h"
#include "slalom/global_planner/OccupiedSegments.h"
#include "slalom/global_planner/RefinementCost.h"
#include "slalom/search/GridSearch.h"

namespace slalom::global_planner
{
/// [m] A point of a plan farther from R than this has left it.
constexpr double kAwayFromR_m = 0.15;

/// What all refinements of one step share.
struct StepContext
{
  const GlobalPlannerConfig& config;  ///< altitudes in the local frame
  const core::Vehicle& vehicle;
  const core::DistanceField& field;
  const spline::UniformBSpline& r;
  ReferenceWindow window;
  std::vector<OccupiedSegment> reference_occupied;  ///< where R itself is nearer than D_z
  double progress = 0.0;                            ///< [s] of the plan
  bool late_return = false;  ///< whether the way back to R is not to be shorter than need be
  double margin = 0.0;       ///< [m] beyond the vehicle's radius that is to be proved
  double hard = 0.0;  ///< [m] clearance that guides and polyhedra keep, with a margin for the grid
  core::Deadline deadline = core::Deadline::none();
};

/// Columns [first, last) of a draft that are to be led along a guide between two free points.
struct Bypass
{
  Eigen::Index first = 0, last = 0;
  Eigen::Vector3d from_L = Eigen::Vector3d::Zero(), to_L = Eigen::Vector3d::Zero();
};

/// The occupied stretches of a draft as columns, widened so that there is room to turn off.
[[nodiscard]] std::vector<Bypass> bypassesOf(const Draft& draft, const StepContext& context);

/// The gap between a draft's fixed columns and the R behind them.
[[nodiscard]] Bypass joinOf(const Draft& draft);

/// A draft that was pushed clear, minimised and examined.
struct Refinement
{
  Draft draft;
  Certificate certificate;   ///< against known obstacles, from the vehicle's progress on
  bool accepted = false;     ///< proved over its whole length
  bool recovered = false;    ///< by projections [Paper Eq. (5)]
  std::string failure;       ///< why not accepted
  double travel_cost = 0.0;  ///< [m] length, dearer where it is nearer than D_z
  core::RefinementRecord record;
};

/** Pushes the draft around its obstacles, minimises J and proves the result; tries again with a
 * stronger J_obs while it is not clear or not comfortably so.
 *  @param bypasses what is to be led around first, in order
 *  @param guides one for each of them */
[[nodiscard]] Refinement refine(const StepContext& context, Draft draft,
                                const std::vector<Bypass>& bypasses,
                                const std::vector<Eigen::Matrix3Xd>& guides);

}  // namespace slalom::global_planner
