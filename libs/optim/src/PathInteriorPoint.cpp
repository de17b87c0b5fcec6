// SPDX-License-Identifier: BSD-3-Clause
#include "PathInteriorPoint.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace slalom::optim::detail
{
using core::SolveReport;
using core::Termination;

PathInteriorPoint::PathInteriorPoint(PathPart& objective, PathPart& rows, Eigen::Matrix3Xd start,
                                     Eigen::Index band, const PathScale& scale)
    : objective_(objective),
      rows_(rows),
      scale_(scale),
      matrix_(start.cols(), band),
      cholesky_(start.cols(), band),
      p_(std::move(start)),
      gradient_(3, p_.cols()),
      step_(3, p_.cols())
{
}

void PathInteriorPoint::linearize()
{
  matrix_.setZero();
  gradient_.setZero();
  state_ = objective_.linearize(p_, matrix_, gradient_);
  state_ += rows_.linearize(p_, matrix_, gradient_);
}

bool PathInteriorPoint::converged() const
{
  const double dual = std::max(gradient_.lpNorm<Eigen::Infinity>(), state_.multiplier_residual);
  return state_.primal_residual <= scale_.primal && dual <= scale_.dual && state_.mu() <= scale_.mu;
}

Reach PathInteriorPoint::direction(double centre, bool corrected)
{
  step_ = -gradient_;
  objective_.addRightHandSide(centre, corrected, step_);
  rows_.addRightHandSide(centre, corrected, step_);
  cholesky_.solveInPlace(step_);
  Reach reach = objective_.expand(step_);
  return reach += rows_.expand(step_);
}

/// One predictor and one corrector with the same factor; false when no progress is possible.
bool PathInteriorPoint::iterate()
{
  if (!cholesky_.compute(matrix_)) return false;
  Reach reach = direction(0.0, false);
  double length = 1.0;
  if (state_.pairs > 0.0)
  {
    const double after =
        state_.complementarity + reach.step * (reach.linear + reach.step * reach.quadratic);
    const double ratio = std::max(0.0, after / state_.complementarity);
    reach = direction(std::pow(ratio, 3) * state_.mu(), true);
    length = std::min(1.0, scale_.fraction * reach.step);
  }
  if (!step_.allFinite() || !(length > 1e-9)) return false;
  p_ += length * step_;
  objective_.move(length);
  rows_.move(length);
  return true;
}

SolveReport PathInteriorPoint::run()
{
  // Multipliers of this size prove that the rows have no common point long before the limit.
  constexpr double kHopeless = 1e12;
  SolveReport report;
  report.termination = Termination::IterationLimit;
  report.message = "iteration limit";
  objective_.initialize(p_, scale_.length, scale_.price);
  rows_.initialize(p_, scale_.length, scale_.price);
  for (;; ++report.iterations)
  {
    linearize();
    if (converged())
    {
      report.termination = Termination::Converged;
      report.message = "optimal";
      break;
    }
    if (report.iterations >= scale_.max_iterations) break;
    if (state_.largest_multiplier > kHopeless * scale_.price || !iterate())
    {
      report.termination = Termination::NumericalFailure;
      report.message = "no further progress";
      break;
    }
  }
  report.dual_residual = gradient_.lpNorm<Eigen::Infinity>();
  return report;
}

}  // namespace slalom::optim::detail
