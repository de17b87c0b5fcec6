// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "slalom/core/DistanceField.h"
#include "slalom/global_planner/GlobalPlannerConfig.h"

namespace slalom::global_planner
{
/// Ways around, and why there is none.
struct GuideSearch
{
  std::vector<Eigen::Matrix3Xd> guides;  ///< topologically distinct, the cheapest first [m]
  std::string reason;                    ///< when there is none
  bool unreachable = false;              ///< the goal is free, but cut off
  Eigen::Vector3d nearest_L = Eigen::Vector3d::Zero();  ///< reachable point nearest to the goal
};

/** Searches up to `count` topologically distinct ways between two places, optimistic field, first
 * near both and then in the whole map (deviation D-04: the guide that [Paper Eq. (2)] silently
 * needs). A place inside hard clearance is left, or reached, by a straight leg of at most 1 m
 * (findRetreat()).
 *  @param hard_clearance smallest distance to obstacles that is ever accepted [m] */
[[nodiscard]] GuideSearch searchGuides(const core::DistanceField& field,
                                       const Eigen::Vector3d& start_L,
                                       const Eigen::Vector3d& goal_L, double hard_clearance,
                                       int count, const GlobalPlannerConfig& config);

}  // namespace slalom::global_planner
