// SPDX-License-Identifier: BSD-3-Clause
#include "slalom/optim/BoxMinimizer.h"

#include <nlopt.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <exception>
#include <limits>
#include <memory>
#include <string>

namespace slalom::optim
{
namespace
{
using core::SolveReport;
using core::Termination;

/// What the callback sees and remembers: NLopt hands back its last point, not its best one.
struct Search
{
  const CostFunction* cost = nullptr;
  const core::Deadline* deadline = nullptr;
  nlopt_opt optimizer = nullptr;

  Eigen::VectorXd x, gradient;            // scratch of one evaluation
  Eigen::VectorXd best_x, best_gradient;  // empty until a finite cost was seen
  double best_cost = std::numeric_limits<double>::infinity();
  int evaluations = 0;
  bool late = false;
  std::string failure;

  double stop(std::string why)
  {
    failure = std::move(why);
    nlopt_force_stop(optimizer);
    return best_cost;
  }
};

/// The C signature of NLopt; nothing may be thrown through it.
double evaluate(unsigned n, const double* x, double* gradient, void* data)
{
  auto& search = *static_cast<Search*>(data);
  // The first evaluation is made even when late: its point is the best one there is.
  if (search.evaluations > 0 && search.deadline->passed())
  {
    search.late = true;
    return search.stop("deadline passed");
  }
  search.x = Eigen::Map<const Eigen::VectorXd>(x, n);
  search.gradient.setZero(n);
  ++search.evaluations;
  double cost = 0.0;
  try
  {
    cost = (*search.cost)(search.x, search.gradient);
  }
  catch (const std::exception& error)
  {
    return search.stop(std::string("the cost function threw: ") + error.what());
  }
  catch (...)
  {
    return search.stop("the cost function threw");
  }
  if (!std::isfinite(cost) || search.gradient.size() != n || !search.gradient.allFinite())
    return search.stop("cost or gradient is not finite");
  if (cost < search.best_cost)
  {
    search.best_cost = cost;
    search.best_x = search.x;
    search.best_gradient = search.gradient;
  }
  if (gradient) Eigen::Map<Eigen::VectorXd>(gradient, n) = search.gradient;
  return cost;
}

/// Largest move of one gradient step that the box permits; zero exactly at a KKT point.
double projectedGradient(const Eigen::VectorXd& x, const Eigen::VectorXd& gradient,
                         const Eigen::VectorXd& lower, const Eigen::VectorXd& upper)
{
  return ((x - gradient).cwiseMax(lower).cwiseMin(upper) - x).lpNorm<Eigen::Infinity>();
}

std::string misuse(const Eigen::VectorXd& start, const Eigen::VectorXd& lower,
                   const Eigen::VectorXd& upper)
{
  if (start.size() == 0) return "no variables";
  if (lower.size() != start.size() || upper.size() != start.size())
    return "bounds and start differ in size";
  if (!start.allFinite()) return "the start is not finite";
  if (lower.hasNaN() || upper.hasNaN()) return "a bound is NaN";
  if ((lower.array() > upper.array()).any()) return "a lower bound exceeds its upper bound";
  return {};
}

using Optimizer = std::unique_ptr<nlopt_opt_s, decltype(&nlopt_destroy)>;

Optimizer makeOptimizer(Search& search, const Eigen::VectorXd& lower, const Eigen::VectorXd& upper,
                        const BoxMinimizerConfig& config)
{
  Optimizer optimizer(nlopt_create(NLOPT_LD_LBFGS, static_cast<unsigned>(lower.size())),
                      &nlopt_destroy);
  if (!optimizer) return optimizer;
  nlopt_set_lower_bounds(optimizer.get(), lower.data());
  nlopt_set_upper_bounds(optimizer.get(), upper.data());
  nlopt_set_min_objective(optimizer.get(), evaluate, &search);
  nlopt_set_maxeval(optimizer.get(), std::max(1, config.max_evaluations));
  nlopt_set_ftol_rel(optimizer.get(), config.relative_tolerance);
  // NLopt's own choice of memory grows with the problem and is many times slower.
  nlopt_set_vector_storage(optimizer.get(), static_cast<unsigned>(std::max(1, config.memory)));
  search.optimizer = optimizer.get();
  return optimizer;
}

void judge(nlopt_result result, const Search& search, const BoxMinimizerConfig& config,
           SolveReport& report)
{
  const double scale = 1.0 + std::abs(search.best_cost);
  if (!search.failure.empty())
  {
    report.termination = search.late ? Termination::TimeLimit : Termination::NumericalFailure;
    report.message = search.failure;
  }
  else if (result == NLOPT_MAXEVAL_REACHED)
  {
    report.termination = Termination::IterationLimit;
    report.message = "evaluation limit";
  }
  else if (result > 0)
  {
    report.termination = Termination::Converged;
    report.message = "cost no longer changes";
  }
  else if (report.dual_residual <= 1e-2 * std::sqrt(config.relative_tolerance) * scale)
  {
    // The line search of NLopt ends with an error when rounding hides any further descent.
    report.termination = Termination::Converged;
    report.message = "stationary to rounding";
  }
  else
  {
    report.termination = Termination::NumericalFailure;
    report.message = "NLopt: " + std::string(nlopt_result_to_string(result));
  }
}

}  // namespace

BoxMinimum minimizeInBox(const CostFunction& cost, const Eigen::VectorXd& start,
                         const Eigen::VectorXd& lower, const Eigen::VectorXd& upper,
                         const BoxMinimizerConfig& config, const core::Deadline& deadline)
{
  const auto begin = std::chrono::steady_clock::now();
  BoxMinimum minimum{start, {}};
  SolveReport& report = minimum.report;
  report.termination = Termination::NumericalFailure;
  report.message = misuse(start, lower, upper);
  if (!report.message.empty()) return minimum;

  minimum.x = start.cwiseMax(lower).cwiseMin(upper);
  Search search;
  search.cost = &cost;
  search.deadline = &deadline;
  const Optimizer optimizer = makeOptimizer(search, lower, upper, config);
  if (!optimizer)
  {
    report.message = "NLopt could not be created";
    return minimum;
  }
  Eigen::VectorXd x = minimum.x;
  double last_cost = 0.0;
  const nlopt_result result = nlopt_optimize(optimizer.get(), x.data(), &last_cost);

  report.iterations = search.evaluations;
  if (search.best_x.size() > 0)
  {
    minimum.x = search.best_x.cwiseMax(lower).cwiseMin(upper);
    report.cost = search.best_cost;
    report.primal_residual = 0.0;
    report.dual_residual = projectedGradient(minimum.x, search.best_gradient, lower, upper);
  }
  judge(result, search, config, report);
  report.wall_time = std::chrono::steady_clock::now() - begin;
  return minimum;
}

}  // namespace slalom::optim
