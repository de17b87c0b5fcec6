// SPDX-License-Identifier: BSD-3-Clause
// The two optimisers of J find the same minimum.
#include <gtest/gtest.h>

#include <optional>
#include <string>

#include "RandomRefinement.h"
#include "SharedData.h"
#include "slalom/optim/BoxMinimizer.h"

namespace slalom::global_planner::test
{
namespace
{
using core::Deadline;
using optim::BoxMethod;
using optim::BoxMinimum;
using optim::minimizeInBox;

constexpr optim::BoxMinimizerConfig kNewton{.max_evaluations = 300, .relative_tolerance = 1e-11};

optim::BoxMinimizerConfig lbfgs(double relative_tolerance)
{
  return {.method = BoxMethod::Lbfgs,
          .max_evaluations = 100000,
          .relative_tolerance = relative_tolerance};
}

/// Residual of the KKT conditions of the box in units of cost: what the quadratic model at x says
/// that moving one variable alone could gain.
double kktResidual(RefinementCost& cost, const Eigen::VectorXd& x, const Eigen::VectorXd& lower,
                   const Eigen::VectorXd& upper)
{
  Eigen::VectorXd gradient;
  (void)cost.evaluate(x, gradient);
  optim::BlockBand hessian(x.size() / 3);
  cost.curvature(x, hessian);
  double most = 0.0;
  for (Eigen::Index i = 0; i < x.size(); ++i)
  {
    const double stiffness = hessian.diagonal[i / 3](i % 3, i % 3);
    const double step = std::clamp(-gradient[i] / stiffness, lower[i] - x[i], upper[i] - x[i]);
    most = std::max(most, -gradient[i] * step - 0.5 * stiffness * step * step);
  }
  return most;
}

/// A random window with a box that is tight for some problems and never met by others.
struct Window
{
  explicit Window(std::uint64_t seed)
  {
    core::Rng rng(seed);
    RefinementCost::Problem problem = randomProblem(rng, 20);
    problem.knot_span = rng.uniform(0.2, 0.4);
    const Eigen::Index free = problem.last_free - problem.first_free + 1;
    const Eigen::VectorXd centre =
        problem.reference.middleCols(problem.first_free, free).reshaped();
    const double room = std::pow(10.0, rng.uniform(-1.5, 1.0));
    lower = centre.array() - room;
    upper = centre.array() + room;
    cost.emplace(std::move(problem), GlobalPlannerConfig{}, core::Vehicle{});
  }
  [[nodiscard]] BoxMinimum minimise(const optim::BoxMinimizerConfig& config)
  {
    return minimizeInBox(*cost, cost->start(), lower, upper, config, Deadline::none());
  }
  std::optional<RefinementCost> cost;
  Eigen::VectorXd lower, upper;
};

TEST(RefinementOptimum, NewtonAndLbfgsAgree)
{
  int active = 0, most_evaluations = 0;
  for (std::uint64_t seed = 1; seed <= 2000; ++seed)
  {
    SCOPED_TRACE(seed);
    Window window(seed);
    const BoxMinimum newton = window.minimise(kNewton);
    EXPECT_TRUE(newton.report.converged()) << newton.report.message;
    EXPECT_LE(kktResidual(*window.cost, newton.x, window.lower, window.upper),
              kNewton.relative_tolerance * newton.report.cost);
    const BoxMinimum other = window.minimise(lbfgs(1e-12));
    EXPECT_NEAR(newton.report.cost, other.report.cost, 1e-6 * other.report.cost);
    active +=
        ((newton.x.array() <= window.lower.array()) || (newton.x.array() >= window.upper.array()))
            .any();
    most_evaluations = std::max(most_evaluations, newton.evaluations);
  }
  EXPECT_GE(active, 500);
  RecordProperty("most_evaluations_of_newton", most_evaluations);
}

TEST(RefinementOptimum, FlightToleranceStaysWithinItsGap)
{
  for (std::uint64_t seed = 1; seed <= 500; ++seed)
  {
    SCOPED_TRACE(seed);
    Window window(seed);
    const BoxMinimum exact = window.minimise(kNewton);
    const BoxMinimum quick = window.minimise({});
    EXPECT_TRUE(quick.report.converged()) << quick.report.message;
    EXPECT_LE(quick.report.cost, exact.report.cost * (1.0 + 1e-4));
  }
}

class RefinementInstances : public testing::TestWithParam<const char*>
{
};
INSTANTIATE_TEST_SUITE_P(Both, RefinementInstances, testing::Values("loose", "tight"),
                         [](const auto& given) { return std::string(given.param); });

TEST_P(RefinementInstances, NewtonAndLbfgsAgree)
{
  const auto file = slalom::test::sharedData(std::string("problems/J_") + GetParam() + "_Nr40.txt");
  if (!exists(file)) GTEST_SKIP() << file << " is absent";
  const auto instances = slalom::test::readRefinementInstances(file);
  ASSERT_GE(instances.size(), 10u);
  for (const auto& instance : instances)
  {
    SCOPED_TRACE(instance.id);
    const InstanceProblem given(instance);
    RefinementCost cost = given.cost();
    const auto minimise = [&](const optim::BoxMinimizerConfig& config) {
      return minimizeInBox(cost, cost.start(), given.lower, given.upper, config, Deadline::none());
    };
    const BoxMinimum newton = minimise(kNewton);
    EXPECT_TRUE(newton.report.converged()) << newton.report.message;
    EXPECT_LE(kktResidual(cost, newton.x, given.lower, given.upper),
              kNewton.relative_tolerance * newton.report.cost);
    const BoxMinimum other = minimise(lbfgs(1e-13));
    EXPECT_LE(newton.report.cost, other.report.cost * (1.0 + 1e-9));
    EXPECT_GE(newton.report.cost, other.report.cost * (1.0 - 1e-6));
  }
}

}  // namespace
}  // namespace slalom::global_planner::test
