// SPDX-License-Identifier: BSD-3-Clause
#include "slalom/optim/PathQp.h"

#include <algorithm>
#include <chrono>

#include "PathInteriorPoint.h"
#include "PathProblem.h"
#include "PathQuadratic.h"
#include "PathRows.h"

namespace slalom::optim
{
namespace
{
/// The path's own squares, with the first end as the origin, so that far-away places lose no
/// digits.
detail::PathQuadratic squaresOf(const PathQp& q)
{
  detail::PathQuadratic squares;
  squares.last = q.last - q.first;
  squares.points = q.points;
  squares.w_start = q.w_start;
  squares.w_end = q.w_end;
  squares.w_length = q.w_length;
  squares.w_bend = q.w_bend;
  return squares;
}

detail::PathScale scaleOf(const PathQp& q, const PathQpConfig& config)
{
  const double stiffness = std::max({q.w_length, q.w_bend, 1e-12});
  const double price = std::max({q.w_start, q.w_end, stiffness});
  detail::PathScale scale;
  scale.length =
      std::max({(q.last - q.first).norm() / static_cast<double>(q.points - 1), 0.1, q.margin});
  scale.price = price * scale.length;
  scale.primal = config.tolerance * scale.length;
  scale.dual = config.tolerance * price * scale.length;
  scale.mu = config.tolerance * stiffness * scale.length * scale.length;
  scale.max_iterations = config.max_iterations;
  return scale;
}
}  // namespace

PathQpSolution solve(const PathQp& q, const PathQpConfig& config)
{
  const auto begin = std::chrono::steady_clock::now();
  PathQpSolution solution;
  core::SolveReport& report = solution.report;
  report.termination = core::Termination::NumericalFailure;
  report.message = detail::misuse(q.first, q.last, q.points, q.sets,
                                  {q.w_start, q.w_end, q.w_length, q.w_bend, q.w_slack, q.margin});
  if (!report.message.empty()) return solution;

  using Relaxation = detail::PathRows::Relaxation;
  detail::PathQuadratic squares = squaresOf(q);
  detail::PathRows rows(q.sets, q.first, q.margin,
                        q.margin > 0.0 ? Relaxation::Capped : Relaxation::Hard, q.w_slack,
                        q.margin);
  detail::PathInteriorPoint interior(
      squares, rows, detail::evenChord(Eigen::Vector3d::Zero(), squares.last, q.points), 2,
      scaleOf(q, config));
  report = interior.run();
  report.cost = squares.cost(interior.points()) + rows.relaxationCost();
  solution.points = interior.points().colwise() + q.first;
  report.primal_residual = detail::violation(q.sets, solution.points);
  if (detail::explainFailure(q.first, q.last, q.sets, report, solution.points))
    report.cost = squares.cost(solution.points.colwise() - q.first);
  report.wall_time = std::chrono::steady_clock::now() - begin;
  return solution;
}

}  // namespace slalom::optim
