// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

#include "slalom/core/SolveReport.h"
#include "slalom/optim/PathSets.h"

namespace slalom::optim
{
/** Strictly convex program over a chain of points p_0..p_n in R^3, each with its own half-spaces:
 *
 *    min  w_start |p_0 - first|^2 + w_end |p_n - last|^2 + w_length sum |p_{k+1} - p_k|^2
 *         + w_bend sum |p_{k+1} - 2 p_k + p_{k-1}|^2 + w_slack sum |xi_k|^2
 *    s.t. A_k p_k <= b_k - margin + xi_k,   0 <= xi_k <= margin       (one xi per row)
 *
 *  The convex form of the pushing problem [Paper Eq. (2)], deviation D-02: index from 0, squares
 * instead of norms (unique, evenly spaced), slack = "clearance `margin` where the gap permits". */
struct PathQp
{
  Eigen::Vector3d first, last;  ///< wanted ends [m]
  Eigen::Index points = 0;      ///< n + 1 >= 2
  PathSets sets;                ///< rows A p <= b
  double w_start = 100.0, w_end = 100.0, w_length = 1.0, w_bend = 1.0, w_slack = 10.0;
  double margin = 0.0;  ///< [m] >= 0; 0 means hard rows without slack
};

struct PathQpSolution
{
  Eigen::Matrix3Xd points;   ///< 3x(n+1) [m]; when Infeasible: the least-violating iterate
  core::SolveReport report;  ///< primal_residual: largest A p - b - (margin's slack bound)
};

struct PathQpConfig
{
  int max_iterations = 50;
  double tolerance = 1e-7;  ///< on the scaled KKT residuals
};

/// Primal-dual interior point on the block-pentadiagonal KKT system; O(n) per iteration.
[[nodiscard]] PathQpSolution solve(const PathQp& problem, const PathQpConfig& config = {});

}  // namespace slalom::optim
