// SPDX-License-Identifier: BSD-3-Clause
#include "slalom/optim/PathSocp.h"

#include <algorithm>
#include <chrono>
#include <optional>

#include "PathCones.h"
#include "PathInteriorPoint.h"
#include "PathProblem.h"
#include "PathRows.h"

namespace slalom::optim
{
namespace
{
using Eigen::Index;
using Eigen::Matrix3Xd;

/** No path costs less than the way between its wanted ends where the end terms weigh at least as
 * much as the length: if the even chord lies in the sets, it is optimal and its tension proves it.
 */
std::optional<PathSocpSolution> chord(const PathSocp& q)
{
  if (q.w_length > std::min(q.w_start, q.w_end)) return std::nullopt;
  PathSocpSolution solution;
  solution.points = detail::evenChord(q.first, q.last, q.points);
  core::SolveReport& report = solution.report;
  report.primal_residual = detail::violation(q.sets, solution.points);
  if (report.primal_residual > 0.0) return std::nullopt;
  const Eigen::Vector3d way = q.last - q.first;
  const double length = way.norm();
  const Eigen::Vector3d tension =
      length > 0.0 ? (q.w_length * way / length).eval() : Eigen::Vector3d::Zero().eval();
  solution.tensions = tension.replicate(1, q.points + 1);
  solution.lower_bound = report.cost = q.w_length * length;
  report.termination = core::Termination::Converged;
  report.dual_residual = 0.0;
  report.message = "even chord";
  return solution;
}

/// By convexity the chord between two solved ends lies in what holds both.
bool sharedByAll(const PathSets& sets)
{
  return std::all_of(sets.begin(), sets.end(),
                     [&](const auto& of_point) { return of_point == sets.front(); });
}

PathSocpSolution interiorPoint(const PathSocp& q, const PathSocpConfig& config)
{
  const Eigen::Vector3d way = q.last - q.first;
  const double weight = std::max({q.w_start, q.w_end, q.w_length});
  detail::PathCones cones(Eigen::Vector3d::Zero(), way, q.points, q.w_start, q.w_end, q.w_length);
  detail::PathRows rows(q.sets, q.first, 0.0, detail::PathRows::Relaxation::Hard, 0.0, 0.0);

  detail::PathScale scale;
  scale.length = std::max(way.norm() / static_cast<double>(q.points - 1), 0.1);
  scale.price = q.w_length;
  scale.primal = config.tolerance * scale.length;
  scale.dual = config.tolerance * weight;
  scale.fraction = 0.98;  // the cones bend: nearer to their boundary the next steps get short
  scale.max_iterations = config.max_iterations;
  const Index pairs = q.points + 1 + rows.size();
  scale.mu = config.tolerance * q.w_length * std::max(way.norm(), 0.1) / static_cast<double>(pairs);
  detail::PathInteriorPoint interior(
      cones, rows, detail::evenChord(Eigen::Vector3d::Zero(), way, q.points), 1, scale);

  PathSocpSolution solution;
  solution.report = interior.run();
  const Matrix3Xd& p = interior.points();
  solution.points = p.colwise() + q.first;
  solution.tensions = cones.tensions();
  solution.report.cost = cones.cost(p);
  solution.lower_bound = solution.report.cost - cones.multiplierSlack(p) - rows.multiplierSlack(p);
  solution.report.primal_residual = detail::violation(q.sets, solution.points);
  if (detail::explainFailure(q.first, q.last, q.sets, solution.report, solution.points))
    solution.report.cost = cones.cost(solution.points.colwise() - q.first);
  return solution;
}

/// The same program with its first and last point only; the others lie on the chord between them.
PathSocpSolution twoPoints(const PathSocp& q, const PathSocpConfig& config)
{
  PathSocp ends = q;
  ends.points = 2;
  ends.sets.resize(2);
  PathSocpSolution solution = interiorPoint(ends, config);
  solution.points =
      detail::evenChord(solution.points.col(0).eval(), solution.points.col(1).eval(), q.points);
  const Matrix3Xd of_ends = solution.tensions;
  solution.tensions = of_ends.col(1).replicate(1, q.points + 1);
  solution.tensions.leftCols(1) = of_ends.col(0);
  solution.tensions.rightCols(1) = of_ends.col(2);
  solution.report.primal_residual = detail::violation(q.sets, solution.points);
  return solution;
}
}  // namespace

PathSocpSolution solve(const PathSocp& q, const PathSocpConfig& config)
{
  const auto begin = std::chrono::steady_clock::now();
  PathSocpSolution solution;
  core::SolveReport& report = solution.report;
  report.termination = core::Termination::NumericalFailure;
  report.message =
      detail::misuse(q.first, q.last, q.points, q.sets, {q.w_start, q.w_end, q.w_length});
  if (report.message.empty() && !(std::min({q.w_start, q.w_end, q.w_length}) > 0.0))
    report.message = "a weight is zero";
  if (!report.message.empty()) return solution;

  if (auto straight = chord(q))
    solution = std::move(*straight);
  else
    solution = sharedByAll(q.sets) ? twoPoints(q, config) : interiorPoint(q, config);
  report.wall_time = std::chrono::steady_clock::now() - begin;
  return solution;
}

}  // namespace slalom::optim
