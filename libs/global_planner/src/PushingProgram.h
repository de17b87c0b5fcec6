// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

#include "slalom/global_planner/PushingDirections.h"
#include "slalom/optim/PathSets.h"

namespace slalom::global_planner
{
/// Eq. (2) ready to be solved: ends, sets per point, and where the points would be without it.
struct PushingProgram
{
  Eigen::Matrix3Xd points;  ///< evenly along the guide, from wanted end to wanted end [m]
  optim::PathSets sets;     ///< one entry per point, its own polyhedron first
  double margin = 0.0;      ///< [m] kept beyond the sets where the gap permits (PushingForm::Qp)
  PushingForm form = PushingForm::Qp;
};

struct PushingProgramSolution
{
  Eigen::Matrix3Xd path;  ///< as many points, evenly spaced by the norms, nearly so by the squares
  PushingMethod method = PushingMethod::Program;
  core::SolveReport solve;  ///< of the program as given
};

/** Solves Eq. (2) in the chosen form. Order of recovery when that fails [Paper Eq. (5)]: every
 * point moves to the nearest point of its sets, or of its own polyhedron where they have none in
 * common; then the convex form smooths the points within what was found feasible; if that fails,
 * too, the projections are the answer. */
[[nodiscard]] PushingProgramSolution solvePushing(const PushingProgram& program);

/// Arc length up to each column [m].
[[nodiscard]] Eigen::VectorXd arcLength(const Eigen::Matrix3Xd& path);

/// `points` places evenly along a polyline with its arc lengths `s`.
[[nodiscard]] Eigen::Matrix3Xd resample(const Eigen::Matrix3Xd& path, const Eigen::VectorXd& s,
                                        Eigen::Index points);

}  // namespace slalom::global_planner
