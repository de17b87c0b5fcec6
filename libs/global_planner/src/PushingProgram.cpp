// SPDX-License-Identifier: BSD-3-Clause
#include "PushingProgram.h"

#include <algorithm>
#include <optional>

#include "slalom/geometry/ConvexDecomposition.h"
#include "slalom/optim/PathQp.h"
#include "slalom/optim/PathSocp.h"

namespace slalom::global_planner
{
namespace
{
using core::HalfSpaces;
using Eigen::Index;
using Eigen::Matrix3Xd;

optim::PathQpSolution solveSquares(const PushingProgram& program, const optim::PathSets& sets)
{
  optim::PathQp qp;
  qp.points = program.points.cols();
  qp.first = program.points.col(0);
  qp.last = program.points.col(qp.points - 1);
  qp.sets = sets;
  qp.margin = program.margin;
  return optim::solve(qp);
}

optim::PathSocpSolution solveNorms(const PushingProgram& program)
{
  optim::PathSocp socp;
  socp.points = program.points.cols();
  socp.first = program.points.col(0);
  socp.last = program.points.col(socp.points - 1);
  socp.sets = program.sets;
  optim::PathSocpSolution solution = optim::solve(socp);
  // The norms leave open where the points lie on the string. Neighbours share a set, so what lies
  // between them is as free as they are.
  if (solution.report.converged())
    solution.points = resample(solution.points, arcLength(solution.points), socp.points);
  return solution;
}

HalfSpaces together(const std::vector<const HalfSpaces*>& sets)
{
  Index rows = 0;
  for (const HalfSpaces* set : sets) rows += set->rows();
  HalfSpaces all;
  all.A.resize(rows, 3);
  all.b.resize(rows);
  rows = 0;
  for (const HalfSpaces* set : sets)
  {
    all.A.middleRows(rows, set->rows()) = set->A;
    all.b.segment(rows, set->rows()) = set->b;
    rows += set->rows();
  }
  return all;
}

/// Dead-zone recovery [Paper Eq. (5)]. It is separable: every point moves by itself. `sets` loses
/// what admits no point.
Matrix3Xd projectAll(Matrix3Xd points, optim::PathSets& sets)
{
  for (Index j = 0; j < points.cols(); ++j)
  {
    auto& of_point = sets[static_cast<std::size_t>(j)];
    while (!of_point.empty())
    {
      if (const auto nearest = geometry::project(points.col(j), together(of_point)))
      {
        points.col(j) = *nearest;
        break;
      }
      of_point.resize(of_point.size() > 1 ? 1 : 0);
    }
  }
  return points;
}
}  // namespace

PushingProgramSolution solvePushing(const PushingProgram& program)
{
  PushingProgramSolution result;
  if (program.form == PushingForm::Socp)
  {
    optim::PathSocpSolution norms = solveNorms(program);
    result.path = std::move(norms.points);
    result.solve = std::move(norms.report);
  }
  else
  {
    optim::PathQpSolution squares = solveSquares(program, program.sets);
    result.path = std::move(squares.points);
    result.solve = std::move(squares.report);
  }
  if (result.solve.converged()) return result;

  optim::PathSets feasible = program.sets;
  result.path = projectAll(program.points, feasible);
  result.method = PushingMethod::Projected;
  optim::PathQpSolution smooth = solveSquares(program, feasible);
  if (!smooth.report.converged()) return result;
  result.path = std::move(smooth.points);
  result.method = PushingMethod::ProjectedAndSmoothed;
  return result;
}

Eigen::VectorXd arcLength(const Matrix3Xd& path)
{
  Eigen::VectorXd s = Eigen::VectorXd::Zero(path.cols());
  for (Index k = 1; k < path.cols(); ++k) s[k] = s[k - 1] + (path.col(k) - path.col(k - 1)).norm();
  return s;
}

Matrix3Xd resample(const Matrix3Xd& path, const Eigen::VectorXd& s, Index points)
{
  Matrix3Xd even(3, points);
  Index k = 0;
  for (Index j = 0; j < points; ++j)
  {
    const double at = s[s.size() - 1] * static_cast<double>(j) / static_cast<double>(points - 1);
    while (k + 2 < s.size() && s[k + 1] < at) ++k;
    const double length = s[k + 1] - s[k];
    const double u = length > 0.0 ? std::clamp((at - s[k]) / length, 0.0, 1.0) : 0.0;
    even.col(j) = (1.0 - u) * path.col(k) + u * path.col(k + 1);
  }
  return even;
}

}  // namespace slalom::global_planner
