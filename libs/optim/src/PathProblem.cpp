// SPDX-License-Identifier: BSD-3-Clause
#include "PathProblem.h"

#include <algorithm>
#include <cmath>

#include "PathInteriorPoint.h"
#include "PathQuadratic.h"
#include "PathRows.h"

namespace slalom::optim::detail
{
using Eigen::Index;
using Eigen::Matrix3Xd;

std::string misuse(const Eigen::Vector3d& first, const Eigen::Vector3d& last, Index points,
                   const PathSets& sets, std::initializer_list<double> weights)
{
  if (points < 2) return "a path needs at least 2 points";
  if (!sets.empty() && static_cast<Index>(sets.size()) != points)
    return "sets and points differ in number";
  if (!first.allFinite() || !last.allFinite()) return "an end is not finite";
  for (const double w : weights)
    if (!(w >= 0.0) || !std::isfinite(w)) return "a weight or the margin is negative or not finite";
  for (const auto& of_point : sets)
    for (const core::HalfSpaces* set : of_point)
      if (set == nullptr || set->A.rows() != set->b.size() || !set->A.allFinite() ||
          !set->b.allFinite())
        return "a set is missing or not finite";
  return {};
}

Matrix3Xd evenChord(const Eigen::Vector3d& a, const Eigen::Vector3d& b, Index points)
{
  Matrix3Xd p(3, points);
  for (Index k = 0; k < points; ++k)
    p.col(k) = a + (b - a) * (static_cast<double>(k) / static_cast<double>(points - 1));
  p.rightCols(1) = b;
  return p;
}

double violation(const PathSets& sets, const Matrix3Xd& p)
{
  double worst = 0.0;
  for (std::size_t k = 0; k < sets.size(); ++k)
  {
    const Eigen::Vector3d point = p.col(static_cast<Index>(k));
    for (const core::HalfSpaces* set : sets[k])
      if (set->rows() > 0) worst = std::max(worst, set->violation(point));
  }
  return worst;
}

Matrix3Xd leastViolating(const Eigen::Vector3d& first, const Eigen::Vector3d& last, Index points,
                         const PathSets& sets)
{
  PathQuadratic path;
  path.last = last - first;
  path.points = points;
  path.w_start = path.w_end = 1e-7;
  path.w_length = path.w_bend = 1e-9;
  PathRows rows(sets, first, 0.0, PathRows::Relaxation::Elastic, 1.0, 0.0);
  PathScale scale;
  scale.length = std::max(path.last.norm() / static_cast<double>(points - 1), 0.1);
  scale.primal = scale.dual = 1e-10 * scale.length;
  scale.mu = 1e-10 * path.w_length * scale.length * scale.length;
  scale.price = scale.length;
  scale.max_iterations = 100;
  PathInteriorPoint interior(path, rows, evenChord(Eigen::Vector3d::Zero(), path.last, points), 2,
                             scale);
  (void)interior.run();
  return interior.points().colwise() + first;
}

bool explainFailure(const Eigen::Vector3d& first, const Eigen::Vector3d& last, const PathSets& sets,
                    core::SolveReport& report, Matrix3Xd& points)
{
  constexpr double kContradiction = 1e-4;  // [m] violation that no path can avoid
  if (report.converged()) return false;
  const Matrix3Xd relaxed = leastViolating(first, last, points.cols(), sets);
  const double unavoidable = violation(sets, relaxed);
  if (!relaxed.allFinite() || !(unavoidable > kContradiction)) return false;
  points = relaxed;
  report.termination = core::Termination::Infeasible;
  report.message = "the sets of a point have no common point";
  report.primal_residual = unavoidable;
  return true;
}

}  // namespace slalom::optim::detail
