// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <vector>

#include "Plan.h"
#include "slalom/local_planner/LocalPlanner.h"

namespace slalom::local_planner::detail
{
/// One row "stay away": normal . (p + lead v) >= offset - slack.
struct KeepOut
{
  Eigen::Vector3d normal;  ///< unit vector obstacle -> free space [1]
  double lead;             ///< [s]
  double offset;           ///< [m] normal . (obstacle point) + asked-for distance
};

/// The obstacles as the NMPC sees them.
struct KeepOuts
{
  std::vector<std::vector<KeepOut>> stages;  ///< N, at the end of each stage
  std::vector<Eigen::Vector3d> points_L;     ///< C_o [m], of the map
  bool finite = true;  ///< false: the field answered with a number that is not finite
};

/// Largest number of rows keepOuts() gives a stage.
[[nodiscard]] int mostRows(const LocalPlannerConfig& config);

/** Rows along the motion that is expected.
 *
 *  - The map: distances linearised where the vehicle is expected to be (CloseObstacles).
 *  - The stop: the last stage's rows hold also where braking from there would end, so that the plan
 *    never counts on flying on beyond its horizon.
 *  - The airspace: its sides, where they are near.
 *  - What moves: each stage keeps away from where the obstacle will be by then, as far as is known.
 *    Where the expected motion meets it, the row leads to the side on which the vehicle passes
 *    anyhow, or else behind it. */
[[nodiscard]] KeepOuts keepOuts(const LocalPlannerInput& input, const Plan& expected,
                                const LocalPlannerConfig& config, const core::Vehicle& vehicle);

/// Distance that the centre of the vehicle keeps from the obstacle's axis at that time, without
/// margin [m]: both radii and two standard deviations of what is known.
[[nodiscard]] double contactDistance(const core::MovingObstacle& mover, double time,
                                     const core::Vehicle& vehicle);

}  // namespace slalom::local_planner::detail
