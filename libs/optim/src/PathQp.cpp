// SPDX-License-Identifier: BSD-3-Clause
#include "slalom/optim/PathQp.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <string>

#include "BlockBandCholesky.h"
#include "PathQpRows.h"

namespace slalom::optim
{
namespace
{
using core::SolveReport;
using core::Termination;
using detail::BlockBand;
using detail::BlockBandCholesky;
using detail::PathQpRows;
using Eigen::Index;
using Eigen::Matrix3Xd;
using Relaxation = PathQpRows::Relaxation;

std::string misuse(const PathQp& q)
{
  if (q.points < 2) return "a path needs at least 2 points";
  if (!q.sets.empty() && static_cast<Index>(q.sets.size()) != q.points)
    return "sets and points differ in number";
  if (!q.first.allFinite() || !q.last.allFinite()) return "an end is not finite";
  for (const double w : {q.w_start, q.w_end, q.w_length, q.w_bend, q.w_slack, q.margin})
    if (!(w >= 0.0) || !std::isfinite(w)) return "a weight or the margin is negative or not finite";
  for (const auto& sets : q.sets)
    for (const core::HalfSpaces* set : sets)
      if (set == nullptr || set->A.rows() != set->b.size() || !set->A.allFinite() ||
          !set->b.allFinite())
        return "a set is missing or not finite";
  return {};
}

void addIsotropic(Eigen::Matrix3d& block, double value)
{
  block.diagonal().array() += value;
}

/// Hessian of the path's own cost; the factor 2 of the squares included.
BlockBand hessianOf(const PathQp& q)
{
  const Index n = q.points;
  BlockBand h(n);
  addIsotropic(h.diagonal[0], 2.0 * q.w_start);
  addIsotropic(h.diagonal[n - 1], 2.0 * q.w_end);
  for (Index k = 0; k + 1 < n; ++k)
  {
    addIsotropic(h.diagonal[k], 2.0 * q.w_length);
    addIsotropic(h.diagonal[k + 1], 2.0 * q.w_length);
    addIsotropic(h.first[k], -2.0 * q.w_length);
  }
  for (Index k = 0; k + 2 < n; ++k)
  {
    addIsotropic(h.diagonal[k], 2.0 * q.w_bend);
    addIsotropic(h.diagonal[k + 1], 8.0 * q.w_bend);
    addIsotropic(h.diagonal[k + 2], 2.0 * q.w_bend);
    addIsotropic(h.first[k], -4.0 * q.w_bend);
    addIsotropic(h.first[k + 1], -4.0 * q.w_bend);
    addIsotropic(h.second[k], 2.0 * q.w_bend);
  }
  return h;
}

double pathCost(const PathQp& q, const Matrix3Xd& p)
{
  const Index n = q.points;
  double cost = q.w_start * (p.col(0) - q.first).squaredNorm() +
                q.w_end * (p.col(n - 1) - q.last).squaredNorm();
  for (Index k = 0; k + 1 < n; ++k) cost += q.w_length * (p.col(k + 1) - p.col(k)).squaredNorm();
  for (Index k = 1; k + 1 < n; ++k)
    cost += q.w_bend * (p.col(k + 1) - 2.0 * p.col(k) + p.col(k - 1)).squaredNorm();
  return cost;
}

/// The same problem with its first end as the origin, so that far-away places lose no digits.
struct Centred
{
  explicit Centred(const PathQp& given) : problem(given), origin(given.first)
  {
    problem.first.setZero();
    problem.last -= origin;
  }
  PathQp problem;
  Eigen::Vector3d origin;
};

PathQpRows rowsOf(const Centred& c, Relaxation relaxation, double weight)
{
  const double margin = relaxation == Relaxation::Capped ? c.problem.margin : 0.0;
  PathQpRows rows(relaxation, weight, margin);
  for (std::size_t k = 0; k < c.problem.sets.size(); ++k)
    for (const core::HalfSpaces* set : c.problem.sets[k])
      for (Index i = 0; i < set->rows(); ++i)
      {
        const Eigen::Vector3d normal = set->A.row(i).transpose();
        rows.add(static_cast<Index>(k), normal, set->b[i] - normal.dot(c.origin) - margin);
      }
  return rows;
}

/// Largest A p - b over all rows, without any margin [m].
double violation(const PathQp& q, const Matrix3Xd& p)
{
  double worst = 0.0;
  for (std::size_t k = 0; k < q.sets.size(); ++k)
    for (const core::HalfSpaces* set : q.sets[k])
      if (set->rows() > 0) worst = std::max(worst, set->violation(p.col(static_cast<Index>(k))));
  return worst;
}

/// Mehrotra's predictor-corrector on one problem.
class InteriorPoint
{
 public:
  InteriorPoint(const Centred& c, PathQpRows rows, const PathQpConfig& config, double price = 0.0)
      : q_(c.problem),
        config_(config),
        rows_(std::move(rows)),
        hessian_(hessianOf(q_)),
        matrix_(q_.points),
        cholesky_(q_.points),
        linear_(Matrix3Xd::Zero(3, q_.points)),
        p_(3, q_.points)
  {
    linear_.col(q_.points - 1) = -2.0 * q_.w_end * q_.last;
    for (Index k = 0; k < q_.points; ++k)
      p_.col(k) = q_.last * (static_cast<double>(k) / static_cast<double>(q_.points - 1));
    stiffness_ = std::max({q_.w_length, q_.w_bend, 1e-12});
    price_ = std::max({q_.w_start, q_.w_end, stiffness_, price});
    length_ = std::max({q_.last.norm() / static_cast<double>(q_.points - 1), 0.1, q_.margin});
  }

  [[nodiscard]] SolveReport run();
  [[nodiscard]] const Matrix3Xd& points() const { return p_; }

 private:
  void updateResiduals();
  [[nodiscard]] bool converged() const;
  [[nodiscard]] bool iterate();
  [[nodiscard]] Matrix3Xd direction(double centre, bool corrected);

  const PathQp& q_;
  const PathQpConfig& config_;
  PathQpRows rows_;
  BlockBand hessian_, matrix_;
  BlockBandCholesky cholesky_;
  Matrix3Xd linear_, p_, gradient_;
  // Typical force of a row per metre, of the path per metre, and distance between points.
  double price_, stiffness_, length_;
};

void InteriorPoint::updateResiduals()
{
  rows_.updateResiduals(p_);
  gradient_ = hessian_.times(p_) + linear_;
  rows_.addMultipliers(gradient_);
}

bool InteriorPoint::converged() const
{
  const double dual = std::max(gradient_.lpNorm<Eigen::Infinity>(), rows_.multiplierResidual());
  return rows_.primalResidual() <= config_.tolerance * length_ &&
         dual <= config_.tolerance * price_ * length_ &&
         rows_.mu() <= config_.tolerance * stiffness_ * length_ * length_;
}

Matrix3Xd InteriorPoint::direction(double centre, bool corrected)
{
  Matrix3Xd step = -gradient_;
  rows_.addRightHandSide(centre, corrected, step);
  cholesky_.solveInPlace(step);
  rows_.expand(step);
  return step;
}

/// One predictor and one corrector with the same factor; false when no progress is possible.
bool InteriorPoint::iterate()
{
  matrix_ = hessian_;
  rows_.condense(matrix_);
  if (!cholesky_.compute(matrix_)) return false;
  Matrix3Xd step = direction(0.0, false);
  double length = 1.0;
  if (rows_.size() > 0)
  {
    const double mu = rows_.mu();
    const double ratio = rows_.muAfter(rows_.longestStep()) / mu;
    step = direction(std::pow(ratio, 3) * mu, true);
    length = std::min(1.0, 0.995 * rows_.longestStep());
  }
  if (!step.allFinite() || !(length > 1e-9)) return false;
  p_ += length * step;
  rows_.move(length);
  return true;
}

SolveReport InteriorPoint::run()
{
  // Multipliers of this size prove that the rows have no common point long before the limit.
  constexpr double kHopeless = 1e12;
  SolveReport report;
  report.termination = Termination::IterationLimit;
  report.message = "iteration limit";
  rows_.initialize(p_, length_, price_ * length_);
  for (;; ++report.iterations)
  {
    updateResiduals();
    if (converged())
    {
      report.termination = Termination::Converged;
      report.message = "optimal";
      break;
    }
    if (report.iterations >= config_.max_iterations) break;
    if (rows_.largestMultiplier() > kHopeless * price_ * length_ || !iterate())
    {
      report.termination = Termination::NumericalFailure;
      report.message = "no further progress";
      break;
    }
  }
  report.cost = pathCost(q_, p_) + rows_.relaxationCost();
  report.dual_residual = gradient_.lpNorm<Eigen::Infinity>();
  return report;
}

/// The same rows, free to be violated at a quadratic price that dwarfs the path's cost: always
/// solvable, and where the rows contradict each other it spreads the violation in least squares.
Matrix3Xd leastViolating(const Centred& c, const PathQpConfig& config)
{
  constexpr double kPathShare = 1e-7;
  Centred faint = c;
  const double heaviest =
      std::max({c.problem.w_start, c.problem.w_end, c.problem.w_length, c.problem.w_bend, 1e-12});
  for (double* weight : {&faint.problem.w_start, &faint.problem.w_end, &faint.problem.w_length,
                         &faint.problem.w_bend})
    *weight *= kPathShare / heaviest;
  PathQpConfig patient = config;
  patient.max_iterations = std::max(100, config.max_iterations);
  patient.tolerance = 1e-10;
  InteriorPoint elastic(faint, rowsOf(faint, Relaxation::Elastic, 1.0), patient, 1.0);
  (void)elastic.run();
  return elastic.points();
}

}  // namespace

PathQpSolution solve(const PathQp& problem, const PathQpConfig& config)
{
  constexpr double kContradiction = 1e-4;  // [m] violation that no path can avoid
  const auto begin = std::chrono::steady_clock::now();
  PathQpSolution solution;
  SolveReport& report = solution.report;
  report.termination = Termination::NumericalFailure;
  report.message = misuse(problem);
  if (!report.message.empty()) return solution;

  const Centred centred(problem);
  const Relaxation relaxation = problem.margin > 0.0 ? Relaxation::Capped : Relaxation::Hard;
  InteriorPoint interior(centred, rowsOf(centred, relaxation, problem.w_slack), config);
  report = interior.run();
  solution.points = interior.points().colwise() + centred.origin;
  report.primal_residual = violation(problem, solution.points);
  if (!report.converged())
  {
    const Matrix3Xd relaxed = leastViolating(centred, config).colwise() + centred.origin;
    const double unavoidable = violation(problem, relaxed);
    if (relaxed.allFinite() && unavoidable > kContradiction)
    {
      solution.points = relaxed;
      report.termination = Termination::Infeasible;
      report.message = "the sets of a point have no common point";
      report.primal_residual = unavoidable;
      report.cost = pathCost(problem, relaxed);
    }
  }
  report.wall_time = std::chrono::steady_clock::now() - begin;
  return solution;
}

}  // namespace slalom::optim
