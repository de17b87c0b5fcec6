// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <string>
#include <vector>

#include "slalom/core/DistanceField.h"
#include "slalom/core/HalfSpaces.h"
#include "slalom/core/SolveReport.h"
#include "slalom/global_planner/GlobalPlannerConfig.h"

namespace slalom::global_planner
{
/// S_*: where the control points of one occupied segment should go, and how it was found.
struct PushingPath
{
  bool found = false;
  std::string reason;      ///< why not, when not found
  bool recovered = false;  ///< the program was infeasible; points are projections [Paper Eq. (5)]
  Eigen::Matrix3Xd guide;  ///< searched way around [m]
  std::vector<core::HalfSpaces>
      polyhedra;          ///< one per piece of the guide, shrunk by the hard clearance
  Eigen::Matrix3Xd path;  ///< S_*, from free end to free end [m]
  core::SolveReport solve;
};

/// Ways around, and why there is none.
struct GuideSearch
{
  std::vector<Eigen::Matrix3Xd> guides;  ///< topologically distinct, the cheapest first [m]
  std::string reason;                    ///< when there is none
  bool unreachable = false;              ///< the goal is free, but cut off
  Eigen::Vector3d nearest_L;             ///< reachable point nearest to the goal
};

/** Searches up to `count` topologically distinct ways from start to goal, optimistic field, first
 * near both and then in the whole map.
 *  @param hard_clearance smallest distance to obstacles that is ever accepted [m] */
[[nodiscard]] GuideSearch searchGuides(const core::DistanceField& field,
                                       const Eigen::Vector3d& start_L,
                                       const Eigen::Vector3d& goal_L, double hard_clearance,
                                       int count, const GlobalPlannerConfig& config);

/** FindPushingDirections [Paper Algorithm 1, lines 4-6; Eq. (2) in its convex form, deviation
 * D-02]: the parallel convex decomposition along a guide and the taut evenly spaced path inside.
 * When the program is infeasible the points are projected onto their polyhedra one by one
 * (dead-zone recovery, Eq. (5)).
 *  @param guide from free end to free end of an occupied segment, >= 2 columns
 *  @param points number of points of S_*, >= 2
 *  @param hard_clearance smallest distance to obstacles that is ever accepted [m] */
[[nodiscard]] PushingPath pushAlong(const core::DistanceField& field, const Eigen::Matrix3Xd& guide,
                                    Eigen::Index points, double hard_clearance,
                                    const GlobalPlannerConfig& config);

}  // namespace slalom::global_planner
