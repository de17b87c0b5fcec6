// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <initializer_list>
#include <string>

#include "slalom/core/SolveReport.h"
#include "slalom/optim/PathSets.h"

/// What the programs over a chain of points have in common around their interior point.
namespace slalom::optim::detail
{
/// What is wrong with the input; empty when nothing is. Weights must be finite and >= 0.
[[nodiscard]] std::string misuse(const Eigen::Vector3d& first, const Eigen::Vector3d& last,
                                 Eigen::Index points, const PathSets& sets,
                                 std::initializer_list<double> weights);

/// `points` evenly from a to b, both included.
[[nodiscard]] Eigen::Matrix3Xd evenChord(const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                                         Eigen::Index points);

/// Largest A p - b over all rows [m], at least 0.
[[nodiscard]] double violation(const PathSets& sets, const Eigen::Matrix3Xd& p);

/** The path that violates the sets least (in least squares), and among those about the shortest.
 * Always solvable: the sets' rows become springs beside which the path's own are faint. */
[[nodiscard]] Eigen::Matrix3Xd leastViolating(const Eigen::Vector3d& first,
                                              const Eigen::Vector3d& last, Eigen::Index points,
                                              const PathSets& sets);

/** Decides whether a solve that did not converge had no chance: if the sets have no common point,
 * the report becomes Infeasible with the unavoidable violation, and `points` the least-violating
 * path. @return true then */
bool explainFailure(const Eigen::Vector3d& first, const Eigen::Vector3d& last, const PathSets& sets,
                    core::SolveReport& report, Eigen::Matrix3Xd& points);

}  // namespace slalom::optim::detail
