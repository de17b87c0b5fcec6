// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

#include "slalom/core/SolveReport.h"
#include "slalom/optim/PathSets.h"

namespace slalom::optim
{
/** The pushing problem in the paper's norms, over a chain of points p_0..p_n in R^3, each with its
 * own half-spaces:
 *
 *    min  w_start |p_0 - first| + w_end |p_n - last| + w_length sum_{k=0}^{n-1} |p_{k+1} - p_k|
 *    s.t. A_k p_k <= b_k
 *
 *  [Paper Eq. (2)] with its index from 0 (deviation D-02): the taut string through the chain of
 * sets. Where w_start, w_end >= w_length the end terms are exact penalties: ends stay where they
 * are wanted as long as their sets hold them. Several solutions may share the smallest cost,
 * because points may slide along the string; PathQp has no such freedom. */
struct PathSocp
{
  Eigen::Vector3d first, last;                        ///< wanted ends [m]
  Eigen::Index points = 0;                            ///< n + 1 >= 2
  PathSets sets;                                      ///< hard rows
  double w_start = 0.8, w_end = 0.8, w_length = 0.6;  ///< > 0
};

struct PathSocpSolution
{
  Eigen::Matrix3Xd points;  ///< 3x(n+1) [m]; when Infeasible: the least-violating path
  /** Forces that prove the cost: 3x(n+2), multipliers y of the terms (first, edges.., last) with
   * |y| <= the term's weight and y.v = weight |v| for the term's vector v, in the order and
   * orientation p_0 - first, p_1 - p_0, .., p_n - p_{n-1}, last - p_n. Where the tension changes
   * from one term to the next, the planes of the point between them carry the difference. */
  Eigen::Matrix3Xd tensions;
  double lower_bound = 0.0;  ///< of the cost, by those multipliers (to dual_residual per metre)
  core::SolveReport report;  ///< primal_residual: largest A p - b; dual_residual: of the forces
};

struct PathSocpConfig
{
  int max_iterations = 50;
  double tolerance = 1e-7;  ///< on the duality gap relative to the cost, and the scaled residuals
};

/** Primal-dual interior point with Nesterov-Todd scaling of the second-order cones, condensed to a
 * block-tridiagonal system; O(n) per iteration. Two shortcuts: when the even chord from first to
 * last lies in the sets, it is the solution; when all points share the same sets, two points decide
 * and the others lie evenly on the chord between them. */
[[nodiscard]] PathSocpSolution solve(const PathSocp& problem, const PathSocpConfig& config = {});

}  // namespace slalom::optim
