// SPDX-License-Identifier: BSD-3-Clause
// Projected Newton after Bertsekas (SIAM J. Control Optim. 20, 1982): variables that press against
// a bound are held there, the others take a Newton step that is bent along the box.
#include <algorithm>
#include <cmath>
#include <vector>

#include "BlockBandCholesky.h"
#include "BoxSearch.h"
#include "InteriorApproach.h"

namespace slalom::optim::detail
{
namespace
{
using core::Termination;
using Eigen::Index;
using Eigen::VectorXd;

class NewtonSearch
{
 public:
  explicit NewtonSearch(const BoxProblem& problem)
      : problem_(problem),
        n_(problem.start.size()),
        hessian_(n_ / 3),
        damped_(n_ / 3),
        cholesky_(n_ / 3),
        held_(static_cast<std::size_t>(n_)),
        step_(3, n_ / 3),
        trial_{problem.start, VectorXd::Zero(n_)},
        good_(trial_)
  {
  }

  [[nodiscard]] BoxResult run();

 private:
  struct Point
  {
    VectorXd x, gradient;
    double cost = std::numeric_limits<double>::infinity();
    double slope = 0.0;  // of the cost along the bent step
  };

  [[nodiscard]] bool evaluate(double length);
  [[nodiscard]] bool linearize();
  void holdPressedVariables();
  [[nodiscard]] bool findStep(double damping);
  [[nodiscard]] bool searchAlongStep();
  [[nodiscard]] bool descend();
  void accept(Point& point);

  const BoxProblem& problem_;
  Index n_;
  BoxResult now_;
  BlockBand hessian_, damped_;
  BlockBandCholesky cholesky_;
  std::vector<char> held_;
  Eigen::Matrix3Xd step_;
  Point trial_, good_;
  double stiffest_ = 1.0;    // largest diagonal entry of the Hessian
  double slope_ = 0.0;       // of the cost along the step of the variables that are not held
  double decrease_ = 0.0;    // that the quadratic model predicts
  double cost_floor_ = 0.0;  // costs are compared relative to no less than this
};

/// The cost at the point `length` along the step, bent into the box.
bool NewtonSearch::evaluate(double length)
{
  if (!mayEvaluate(problem_, now_)) return false;
  const auto step = step_.reshaped();
  if (length > 0.0)
    trial_.x = (now_.x + length * step).cwiseMax(problem_.lower).cwiseMin(problem_.upper);
  ++now_.evaluations;
  std::string failure;
  trial_.cost = evaluateSafely([&] { return problem_.cost.evaluate(trial_.x, trial_.gradient); },
                               n_, trial_.gradient, failure);
  if (!failure.empty())
  {
    now_.stop(Termination::NumericalFailure, std::move(failure));
    return false;
  }
  trial_.slope = 0.0;
  for (Index i = 0; i < n_; ++i)
    if (!held_[i] && trial_.x[i] > problem_.lower[i] && trial_.x[i] < problem_.upper[i])
      trial_.slope += trial_.gradient[i] * step(i);
  return true;
}

void NewtonSearch::accept(Point& point)
{
  now_.x.swap(point.x);
  now_.gradient.swap(point.gradient);
  now_.cost = point.cost;
}

bool NewtonSearch::linearize()
{
  ++now_.iterations;
  problem_.cost.curvature(now_.x, hessian_);
  stiffest_ = 0.0;
  for (const Eigen::Matrix3d& block : hessian_.diagonal)
    stiffest_ = std::max(stiffest_, block.diagonal().maxCoeff());
  if (!std::isfinite(stiffest_))
  {
    now_.stop(Termination::NumericalFailure, "the curvature is not finite");
    return false;
  }
  if (stiffest_ <= 0.0) stiffest_ = 1.0;
  holdPressedVariables();
  return true;
}

/// A variable is held when the gradient presses it against a bound that is nearer than a step of
/// its own would reach; without that width the set could change at every step and the search stall.
void NewtonSearch::holdPressedVariables()
{
  constexpr double kWidest = 1e-3, kSoftest = 1e-8;
  double reach = 0.0;
  for (Index i = 0; i < n_; ++i)
  {
    const double stiffness = std::max(kSoftest * stiffest_, hessian_.diagonal[i / 3](i % 3, i % 3));
    const double to =
        std::clamp(now_.x[i] - now_.gradient[i] / stiffness, problem_.lower[i], problem_.upper[i]);
    reach = std::max(reach, std::abs(to - now_.x[i]));
  }
  const double near = std::min(kWidest, reach);
  for (Index i = 0; i < n_; ++i)
  {
    const double g = now_.gradient[i];
    held_[i] = (g > 0.0 && now_.x[i] - problem_.lower[i] <= near) ||
               (g < 0.0 && problem_.upper[i] - now_.x[i] <= near) ||
               problem_.lower[i] == problem_.upper[i];
  }
}

/// Held variables go to their bounds, the others where the (damped) quadratic model is least.
bool NewtonSearch::findStep(double damping)
{
  damped_ = hessian_;
  for (Eigen::Matrix3d& block : damped_.diagonal) block.diagonal().array() += damping;
  hold(damped_, [this](Index i) { return held_[i]; });
  if (!cholesky_.compute(damped_)) return false;
  auto step = step_.reshaped();
  for (Index i = 0; i < n_; ++i) step(i) = held_[i] ? 0.0 : -now_.gradient[i];
  cholesky_.solveInPlace(step_);
  slope_ = 0.0;
  double held_slope = 0.0;
  for (Index i = 0; i < n_; ++i)
  {
    const double g = now_.gradient[i];
    if (held_[i]) step(i) = (g > 0.0 ? problem_.lower[i] : problem_.upper[i]) - now_.x[i];
    (held_[i] ? held_slope : slope_) += g * step(i);
  }
  decrease_ = -0.5 * slope_ - held_slope;
  return step_.allFinite() && slope_ <= 0.0;
}

/// Leaves the best of a few points along the step in good_; false if none is better enough.
bool NewtonSearch::searchAlongStep()
{
  constexpr double kEnough = 1e-4, kFlat = 0.5, kShortest = 1e-10;
  constexpr int kRefinements = 8;
  double low = 0.0, high = std::numeric_limits<double>::infinity();
  double low_slope = slope_, high_slope = 0.0, length = 1.0;
  good_.cost = std::numeric_limits<double>::infinity();
  for (int k = 0; length > kShortest; ++k)
  {
    if (!evaluate(length)) break;
    const bool better = trial_.cost < now_.cost + kEnough * length * slope_;
    const double slope = trial_.slope;
    if (better && trial_.cost < good_.cost) std::swap(trial_, good_);
    if (better && std::abs(slope) <= kFlat * std::abs(slope_)) break;
    if (std::isfinite(good_.cost) && k >= kRefinements) break;
    if (!better || slope > 0.0)
      high = length, high_slope = slope;
    else
      low = length, low_slope = slope;
    if (std::isinf(high))
    {
      if (length >= 4.0) break;
      length *= 2.0;
      continue;
    }
    const double width = high - low;
    const double secant = high_slope > 0.0 ? -low_slope / (high_slope - low_slope) : 0.5;
    length = low + width * std::clamp(secant, 0.1, 0.9);
  }
  return std::isfinite(good_.cost);
}

/// One step down, damped until there is one; false when the search is over.
bool NewtonSearch::descend()
{
  constexpr double kFirst = 1e-15, kNext = 1e-10, kLast = 1e6;  // relative damping
  constexpr double kRounding = 1e-10;  // what a stiff cost may hide, relative to its value
  const double before = now_.cost;
  const double scale = std::max(std::abs(before), cost_floor_);
  const double enough = problem_.config.relative_tolerance * scale;
  bool searched = false, little_left = false, only_rounding_left = false;
  for (double damping = kFirst; damping <= kLast; damping = std::max(kNext, 100.0 * damping))
  {
    if (!findStep(damping * stiffest_)) continue;
    // What a step that had to be shortened promises says nothing about the minimum.
    if (!searched)
    {
      little_left = decrease_ <= enough;
      only_rounding_left = decrease_ <= kRounding * scale;
      searched = true;
    }
    const bool better = searchAlongStep();
    if (better) accept(good_);
    if (!now_.message.empty()) return false;
    if (little_left && before - now_.cost <= enough)
    {
      now_.stop(Termination::Converged, "no further decrease to expect");
      return false;
    }
    if (better) return true;
  }
  if (only_rounding_left)
    now_.stop(Termination::Converged, "stationary to rounding");
  else
    now_.stop(Termination::NumericalFailure, "no descent found");
  return false;
}

BoxResult NewtonSearch::run()
{
  step_.setZero();
  if (!evaluate(0.0)) return now_;
  now_.x = trial_.x;
  now_.gradient = trial_.gradient;
  now_.cost = trial_.cost;
  // A minimum of zero would never be reached relatively.
  cost_floor_ = 1e-9 * std::abs(now_.cost);
  auto* limited = dynamic_cast<LimitedCost*>(&problem_.cost);
  bool goes_on = !limited || limited->limits().rows() == 0 || approach(problem_, *limited, now_);
  while (goes_on)
  {
    if (projectedGradient(problem_, now_.x, now_.gradient) == 0.0)
    {
      now_.stop(Termination::Converged, "stationary");
      break;
    }
    goes_on = linearize() && descend();
  }
  return now_;
}

}  // namespace

BoxResult minimizeByNewton(const BoxProblem& problem)
{
  return NewtonSearch(problem).run();
}

}  // namespace slalom::optim::detail
