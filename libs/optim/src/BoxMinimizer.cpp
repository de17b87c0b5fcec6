// SPDX-License-Identifier: BSD-3-Clause
#include "slalom/optim/BoxMinimizer.h"

#include <chrono>
#include <limits>
#include <string>

#include "BoxSearch.h"

namespace slalom::optim
{
namespace
{
std::string misuse(const Eigen::VectorXd& start, const Eigen::VectorXd& lower,
                   const Eigen::VectorXd& upper, BoxMethod method)
{
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  if (start.size() == 0) return "no variables";
  if (lower.size() != start.size() || upper.size() != start.size())
    return "bounds and start differ in size";
  if (method == BoxMethod::Newton && start.size() % 3 != 0)
    return "the variables are not points in space";
  if (!start.allFinite()) return "the start is not finite";
  if (lower.hasNaN() || upper.hasNaN()) return "a bound is NaN";
  if ((lower.array() > upper.array()).any()) return "a lower bound exceeds its upper bound";
  if ((lower.array() == kInfinity).any() || (upper.array() == -kInfinity).any())
    return "a bound leaves no finite point";
  return {};
}
}  // namespace

bool detail::mayEvaluate(const BoxProblem& problem, BoxResult& result)
{
  if (result.evaluations == 0) return true;
  if (result.evaluations >= problem.config.max_evaluations)
    result.stop(core::Termination::IterationLimit, "evaluation limit");
  else if (problem.deadline.passed())
    result.stop(core::Termination::TimeLimit, "deadline passed");
  else
    return true;
  return false;
}

void detail::addToDiagonal(BlockBand& matrix, const Eigen::ArrayXd& values)
{
  for (Eigen::Index k = 0; k < matrix.blocks(); ++k)
    matrix.diagonal[k].diagonal() += values.segment<3>(3 * k).matrix();
}

double detail::projectedGradient(const BoxProblem& problem, const Eigen::VectorXd& x,
                                 const Eigen::VectorXd& gradient)
{
  return (-gradient)
      .cwiseMax(problem.lower - x)
      .cwiseMin(problem.upper - x)
      .lpNorm<Eigen::Infinity>();
}

BoxMinimum minimizeInBox(BandedCost& cost, const Eigen::VectorXd& start,
                         const Eigen::VectorXd& lower, const Eigen::VectorXd& upper,
                         const BoxMinimizerConfig& config, const core::Deadline& deadline)
{
  const auto begin = std::chrono::steady_clock::now();
  BoxMinimum minimum;
  core::SolveReport& report = minimum.report;
  minimum.x = start;
  report.termination = core::Termination::NumericalFailure;
  report.message = misuse(start, lower, upper, config.method);
  if (!report.message.empty()) return minimum;

  minimum.x = start.cwiseMax(lower).cwiseMin(upper);
  const detail::BoxProblem problem{cost, minimum.x, lower, upper, config, deadline};
  detail::BoxResult result = config.method == BoxMethod::Newton ? detail::minimizeByNewton(problem)
                                                                : detail::minimizeByLbfgs(problem);
  report.termination = result.termination;
  report.message = std::move(result.message);
  report.iterations = result.iterations;
  minimum.evaluations = result.evaluations;
  if (result.gradient.size() > 0)
  {
    report.cost = result.cost;
    report.primal_residual = 0.0;
    report.dual_residual = detail::projectedGradient(problem, result.x, result.gradient);
    minimum.x = std::move(result.x);
  }
  report.wall_time = std::chrono::steady_clock::now() - begin;
  return minimum;
}

}  // namespace slalom::optim
