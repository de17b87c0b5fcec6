// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <string>
#include <string_view>
#include <vector>

#include "slalom/core/DistanceField.h"
#include "slalom/core/HalfSpaces.h"
#include "slalom/core/SolveReport.h"
#include "slalom/global_planner/GlobalPlannerConfig.h"

namespace slalom::global_planner
{
/// How S_* was obtained, in the order in which it is tried.
enum class PushingMethod
{
  Program,               ///< Eq. (2)
  ProjectedAndSmoothed,  ///< Eq. (2) was infeasible: Eq. (5), smoothed within the polyhedra
  Projected              ///< Eq. (5) alone
};
[[nodiscard]] std::string_view toString(PushingMethod method);

/// S_*: where the control points of one occupied segment should go, and how it was found.
struct PushingPath
{
  std::string reason;      ///< what happened, when recovered
  bool recovered = false;  ///< method is not Program [Paper Eq. (5)]
  PushingMethod method = PushingMethod::Program;
  Eigen::Matrix3Xd guide;  ///< searched way around, with the legs below [m]
  std::vector<core::HalfSpaces>
      polyhedra;          ///< one per piece of the guide, shrunk by the hard clearance
  Eigen::Matrix3Xd path;  ///< S_*, from end to end [m]
  /// Length of the straight first (last) leg of S_* and of the guide that leads out of (into) hard
  /// clearance [m]; 0 when the end keeps it.
  double retreat_m = 0.0, approach_m = 0.0;
  core::SolveReport solve;  ///< of Eq. (2)
};

/** FindPushingDirections [Paper Algorithm 1, lines 4-6] along a guide: the parallel convex
 * decomposition of its pieces and Eq. (2) inside, in the form that the configuration names. The
 * squares (deviation D-02) keep clearance_m where the gap permits; the paper's norms give the taut
 * string, which touches what the hard clearance leaves. When the program is infeasible: dead-zone
 * recovery (Eq. (5)).
 *  @param guide >= 2 columns, from end to end. It keeps hard_clearance; but if its first or last
 * point does not, the edge to its neighbour is a leg that is flown straight
 *  @param points number of points of S_*, >= 2; it gets more where a leg needs them
 *  @param hard_clearance smallest distance to obstacles that is ever accepted [m] */
[[nodiscard]] PushingPath pushAlong(const core::DistanceField& field, const Eigen::Matrix3Xd& guide,
                                    Eigen::Index points, double hard_clearance,
                                    const GlobalPlannerConfig& config);

}  // namespace slalom::global_planner
