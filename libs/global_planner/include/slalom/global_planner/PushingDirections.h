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

/** FindPushingDirections [Paper Algorithm 1, lines 4-6; Eq. (2) in its convex form, deviation
 * D-02]: a guide around the obstacle between the free ends, the parallel convex decomposition along
 * it, and the taut evenly spaced path inside. When the program is infeasible the points are
 * projected onto their polyhedra one by one (dead-zone recovery, Eq. (5)).
 *  @param start_L, goal_L free ends of the occupied segment
 *  @param points number of points of S_*, >= 2
 *  @param hard_clearance smallest distance to obstacles that is ever accepted [m] */
[[nodiscard]] PushingPath findPushingPath(const core::DistanceField& field,
                                          const Eigen::Vector3d& start_L,
                                          const Eigen::Vector3d& goal_L, Eigen::Index points,
                                          double hard_clearance, const GlobalPlannerConfig& config);

}  // namespace slalom::global_planner
