// SPDX-License-Identifier: BSD-3-Clause
#include "InteriorApproach.h"

#include <algorithm>
#include <cmath>

#include "Barrier.h"
#include "BlockBandCholesky.h"

namespace slalom::optim::detail
{
namespace
{
using core::Termination;
using Eigen::ArrayXd;
using Eigen::Index;
using Eigen::VectorXd;

class InteriorPoint
{
 public:
  InteriorPoint(const BoxProblem& problem, LimitedCost& cost, BoxResult& best)
      : problem_(problem),
        cost_(cost),
        best_(best),
        limits_(cost.limits()),
        n_(problem.start.size()),
        box_(problem.lower.array(), problem.upper.array()),
        kept_(-limits_.limit(), limits_.limit()),
        stiffness_(2.0 * limits_.weight()),
        hessian_(n_ / 3),
        cholesky_(n_ / 3),
        step_(3, n_ / 3),
        smooth_gradient_(n_),
        gradient_(n_),
        rhs_(n_)
  {
  }

  [[nodiscard]] bool run();

 private:
  [[nodiscard]] bool evaluate();
  [[nodiscard]] bool factorize();
  void solve();
  void iterate();

  const BoxProblem& problem_;
  LimitedCost& cost_;
  BoxResult& best_;
  const SoftLimits& limits_;
  Index n_;
  Barrier box_, kept_;  // of x and of p, the part of each difference that costs nothing
  ArrayXd stiffness_;   // of the springs between d and p
  BlockBand hessian_;
  BlockBandCholesky cholesky_;
  Eigen::Matrix3Xd step_;
  VectorXd x_, smooth_gradient_, gradient_, rhs_, dx_;
  ArrayXd d_, dd_, force_, dp_;
  ArrayXd inverse_, effective_;  // of springs and barriers together
  double smallest_step_ = 1.0;
};

/// Cost, gradient and difference rows at x; remembers the best point.
bool InteriorPoint::evaluate()
{
  if (!mayEvaluate(problem_, best_)) return false;
  ++best_.evaluations;
  const auto smooth = [&] { return cost_.evaluateSmooth(x_, smooth_gradient_); };
  std::string failure;
  double cost = evaluateSafely(smooth, n_, smooth_gradient_, failure);
  if (!failure.empty())
  {
    best_.stop(Termination::NumericalFailure, std::move(failure));
    return false;
  }
  limits_.differences(x_, d_);
  force_ = d_ - d_.max(-limits_.limit()).min(limits_.limit());
  cost += (limits_.weight() * force_.square()).sum() + limits_.constantCost();
  if (cost < best_.cost)
  {
    force_ *= stiffness_;
    gradient_ = smooth_gradient_;
    limits_.addForce(force_, gradient_);
    best_.x = x_;
    best_.cost = cost;
    best_.gradient = gradient_;
  }
  force_ = stiffness_ * (d_ - kept_.value());
  return true;
}

bool InteriorPoint::factorize()
{
  cost_.curvatureSmooth(x_, hessian_);
  box_.linearize();
  kept_.linearize();
  // Spring and barrier in series.
  inverse_ = 1.0 / (stiffness_ + kept_.stiffness());
  effective_ = stiffness_ * kept_.stiffness() * inverse_;
  limits_.addStiffness(effective_, hessian_);
  addToDiagonal(hessian_, box_.stiffness());
  hold(hessian_, [this](Index i) { return box_.held(i); });
  return cholesky_.compute(hessian_);
}

/// The direction that belongs to the right-hand sides of the barriers.
void InteriorPoint::solve()
{
  // After the step the springs pull with effective * dd + this.
  dp_ = (force_ * kept_.stiffness() - stiffness_ * kept_.push()) * inverse_;
  rhs_ = smooth_gradient_;
  limits_.addForce(dp_, rhs_);
  rhs_ = box_.push().matrix() - rhs_;
  for (Index i = 0; i < n_; ++i)
    if (box_.held(i)) rhs_[i] = 0.0;
  step_.reshaped() = rhs_;
  cholesky_.solveInPlace(step_);
  dx_ = step_.reshaped();
  limits_.changes(dx_, dd_);
  dp_ = (stiffness_ * dd_ + force_ + kept_.push()) * inverse_;
  box_.expand(dx_.array());
  kept_.expand(dp_);
}

/// Mehrotra's predictor and corrector with one factor.
void InteriorPoint::iterate()
{
  const double now = box_.complementarity() + kept_.complementarity();
  double primal = 1.0, dual = 1.0;
  solve();
  box_.limitSteps(primal, dual);
  kept_.limitSteps(primal, dual);
  const double then =
      box_.complementarityAfter(primal, dual) + kept_.complementarityAfter(primal, dual);
  const double centring = std::pow(std::max(0.0, then / now), 3);
  const double mu = centring * now / (box_.sides() + kept_.sides());
  box_.correct(mu);
  kept_.correct(mu);
  solve();
  constexpr double kKeepAway = 0.995;
  primal = dual = 1.0 / kKeepAway;
  box_.limitSteps(primal, dual);
  kept_.limitSteps(primal, dual);
  primal = std::min(1.0, kKeepAway * primal);
  dual = std::min(1.0, kKeepAway * dual);
  smallest_step_ = std::min(primal, dual);
  box_.move(primal, dual);
  kept_.move(primal, dual);
  x_ = box_.value().matrix().cwiseMax(problem_.lower).cwiseMin(problem_.upper);
}

bool InteriorPoint::run()
{
  constexpr int kMaxIterations = 40;
  // A start in the middle of the allowed differences and a barrier as large as the cost
  // converge in the fewest iterations, whatever the start.
  constexpr double kBoxShare = 0.1, kMiddle = 0.5, kFirstBarrier = 3.0;
  const double mu = kFirstBarrier * std::abs(best_.cost) / (box_.sides() + kept_.sides());
  if (!(mu > 0.0) || !(limits_.limit() > 0.0).all()) return true;
  box_.start(problem_.start.array(), kBoxShare, mu);
  kept_.start(ArrayXd::Zero(limits_.rows()), kMiddle, mu);
  x_ = box_.value().matrix();
  for (int k = 0; k < kMaxIterations; ++k)
  {
    if (!evaluate()) return false;
    const double gap = box_.complementarity() + kept_.complementarity();
    if (!(gap > 0.1 * problem_.config.relative_tolerance * std::abs(best_.cost))) break;
    ++best_.iterations;
    if (!factorize()) break;
    iterate();
    if (!x_.allFinite() || smallest_step_ < 1e-6) break;
  }
  return true;
}

}  // namespace

bool approach(const BoxProblem& problem, LimitedCost& cost, BoxResult& best)
{
  return InteriorPoint(problem, cost, best).run();
}

}  // namespace slalom::optim::detail
