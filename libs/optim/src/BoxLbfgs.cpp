// SPDX-License-Identifier: BSD-3-Clause
#include <nlopt.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>

#include "BoxSearch.h"

namespace slalom::optim::detail
{
namespace
{
using core::Termination;

/// What the callback sees and remembers: NLopt hands back its last point, not its best one.
struct Search
{
  const BoxProblem* problem = nullptr;
  nlopt_opt optimizer = nullptr;
  BoxResult best;
  Eigen::VectorXd x, gradient;  // scratch of one evaluation
  bool late = false;
  std::string failure;

  double stop()
  {
    nlopt_force_stop(optimizer);
    return best.cost;
  }
};

/// The C signature of NLopt; nothing may be thrown through it.
double evaluate(unsigned n, const double* x, double* gradient, void* data)
{
  auto& search = *static_cast<Search*>(data);
  // The first evaluation is made even when late: its point is the best one there is.
  if (search.best.evaluations > 0 && search.problem->deadline.passed())
  {
    search.late = true;
    search.failure = "deadline passed";
    return search.stop();
  }
  search.x = Eigen::Map<const Eigen::VectorXd>(x, n);
  search.gradient.setZero(n);
  ++search.best.evaluations;
  const auto cost_at_x = [&] { return search.problem->cost.evaluate(search.x, search.gradient); };
  const double cost = evaluateSafely(cost_at_x, n, search.gradient, search.failure);
  if (!search.failure.empty()) return search.stop();
  if (cost < search.best.cost)
  {
    search.best.cost = cost;
    search.best.x = search.x;
    search.best.gradient = search.gradient;
  }
  if (gradient) Eigen::Map<Eigen::VectorXd>(gradient, n) = search.gradient;
  return cost;
}

using Optimizer = std::unique_ptr<nlopt_opt_s, decltype(&nlopt_destroy)>;

Optimizer makeOptimizer(Search& search)
{
  const BoxProblem& problem = *search.problem;
  const BoxMinimizerConfig& config = problem.config;
  Optimizer optimizer(nlopt_create(NLOPT_LD_LBFGS, static_cast<unsigned>(problem.start.size())),
                      &nlopt_destroy);
  if (!optimizer) return optimizer;
  nlopt_set_lower_bounds(optimizer.get(), problem.lower.data());
  nlopt_set_upper_bounds(optimizer.get(), problem.upper.data());
  nlopt_set_min_objective(optimizer.get(), evaluate, &search);
  nlopt_set_maxeval(optimizer.get(), std::max(1, config.max_evaluations));
  nlopt_set_ftol_rel(optimizer.get(), config.relative_tolerance);
  // NLopt's own choice of memory grows with the problem and is many times slower.
  nlopt_set_vector_storage(optimizer.get(), static_cast<unsigned>(std::max(1, config.memory)));
  search.optimizer = optimizer.get();
  return optimizer;
}

void judge(nlopt_result result, Search& search)
{
  BoxResult& best = search.best;
  if (!search.failure.empty())
  {
    best.termination = search.late ? Termination::TimeLimit : Termination::NumericalFailure;
    best.message = search.failure;
  }
  else if (result == NLOPT_MAXEVAL_REACHED)
  {
    best.termination = Termination::IterationLimit;
    best.message = "evaluation limit";
  }
  else if (result > 0)
  {
    best.termination = Termination::Converged;
    best.message = "cost no longer changes";
  }
  else if (best.gradient.size() > 0 &&
           projectedGradient(*search.problem, best.x, best.gradient) <=
               1e-2 * std::sqrt(search.problem->config.relative_tolerance) *
                   (1.0 + std::abs(best.cost)))
  {
    // The line search of NLopt ends with an error when rounding hides any further descent.
    best.termination = Termination::Converged;
    best.message = "stationary to rounding";
  }
  else
  {
    best.termination = Termination::NumericalFailure;
    best.message = "NLopt: " + std::string(nlopt_result_to_string(result));
  }
}

}  // namespace

BoxResult minimizeByLbfgs(const BoxProblem& problem)
{
  Search search;
  search.problem = &problem;
  const Optimizer optimizer = makeOptimizer(search);
  if (!optimizer)
  {
    search.best.message = "NLopt could not be created";
    return search.best;
  }
  Eigen::VectorXd x = problem.start;
  double last_cost = 0.0;
  const nlopt_result result = nlopt_optimize(optimizer.get(), x.data(), &last_cost);
  // NLopt may leave the box by a rounding.
  if (search.best.x.size() > 0)
    search.best.x = search.best.x.cwiseMax(problem.lower).cwiseMin(problem.upper);
  search.best.iterations = search.best.evaluations;
  judge(result, search);
  return search.best;
}

}  // namespace slalom::optim::detail
