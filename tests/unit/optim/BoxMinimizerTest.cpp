// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <limits>
#include <stdexcept>

#include "slalom/core/Rng.h"
#include "slalom/optim/BoxMinimizer.h"

namespace
{
using Eigen::MatrixXd;
using Eigen::VectorXd;
using slalom::core::Deadline;
using slalom::core::Rng;
using slalom::core::Termination;
using slalom::optim::BoxMinimizerConfig;
using slalom::optim::BoxMinimum;
using slalom::optim::minimizeInBox;

/// A convex quadratic whose minimum in its box is known by construction.
struct KnownMinimum
{
  explicit KnownMinimum(std::uint64_t seed)
  {
    Rng rng(seed);
    const int n = rng.integer(1, 40);
    MatrixXd factor(n, n);
    for (double& value : factor.reshaped()) value = rng.normal();
    Q = factor * factor.transpose() / n + 0.5 * MatrixXd::Identity(n, n);
    minimum.resize(n), slope.resize(n), lower.resize(n), upper.resize(n), start.resize(n);
    for (int i = 0; i < n; ++i)
    {
      minimum[i] = rng.uniform(-3.0, 3.0);
      const int kind = rng.integer(0, 3);  // 0, 1: free; 2: at the lower bound; 3: at the upper
      slope[i] = kind < 2 ? 0.0 : (kind == 2 ? 1.0 : -1.0) * rng.uniform(0.1, 3.0);
      lower[i] = minimum[i] - (kind == 2 ? 0.0 : rng.uniform(0.1, 2.0));
      upper[i] = minimum[i] + (kind == 3 ? 0.0 : rng.uniform(0.1, 2.0));
      start[i] = rng.uniform(lower[i] - 1.0, upper[i] + 1.0);
    }
  }
  double operator()(const VectorXd& x, VectorXd& gradient) const
  {
    const VectorXd e = x - minimum;
    gradient = Q * e + slope;
    return 0.5 * e.dot(Q * e) + slope.dot(e) + 1.0;
  }
  MatrixXd Q;
  VectorXd minimum, slope, lower, upper, start;
};

constexpr BoxMinimizerConfig kTight{.max_evaluations = 2000, .relative_tolerance = 1e-14};

TEST(BoxMinimizer, FindsKnownMinimaWithActiveBounds)
{
  for (std::uint64_t seed = 1; seed <= 300; ++seed)
  {
    SCOPED_TRACE(seed);
    const KnownMinimum problem(seed);
    const BoxMinimum found = minimizeInBox(problem, problem.start, problem.lower, problem.upper,
                                           kTight, Deadline::none());
    EXPECT_TRUE(found.report.converged()) << found.report.message;
    EXPECT_LE((found.x - problem.minimum).lpNorm<Eigen::Infinity>(), 1e-4);
    EXPECT_NEAR(found.report.cost, 1.0, 1e-8);
    EXPECT_LE(found.report.dual_residual, 1e-3);
  }
}

TEST(BoxMinimizer, EvaluatesInsideTheBoxAndReturnsTheBestPointSeen)
{
  for (std::uint64_t seed = 1; seed <= 100; ++seed)
  {
    SCOPED_TRACE(seed);
    const KnownMinimum problem(seed);
    double best = std::numeric_limits<double>::infinity();
    int evaluations = 0;
    const auto watched = [&](const VectorXd& x, VectorXd& gradient)
    {
      EXPECT_TRUE((x.array() >= problem.lower.array()).all());
      EXPECT_TRUE((x.array() <= problem.upper.array()).all());
      ++evaluations;
      const double cost = problem(x, gradient);
      best = std::min(best, cost);
      return cost;
    };
    const BoxMinimum found = minimizeInBox(watched, problem.start, problem.lower, problem.upper,
                                           {.max_evaluations = 6}, Deadline::none());
    EXPECT_LE(evaluations, 6);
    EXPECT_EQ(found.report.iterations, evaluations);
    EXPECT_EQ(found.report.cost, best);
    VectorXd gradient;
    EXPECT_EQ(problem(found.x, gradient), best);
  }
}

TEST(BoxMinimizer, KeepsFixedVariablesAndReportsTheIterationLimit)
{
  // Rosenbrock's valley with one variable held.
  const auto cost = [](const VectorXd& x, VectorXd& gradient)
  {
    const double a = 1.0 - x[0], b = x[1] - x[0] * x[0];
    gradient = Eigen::Vector3d(-2.0 * a - 400.0 * x[0] * b, 200.0 * b, 2.0 * x[2]);
    return a * a + 100.0 * b * b + x[2] * x[2];
  };
  constexpr double kCostOfStart = 24.2 + 0.49;
  const Eigen::Vector3d start(-1.2, 1.0, 0.7), lower(-5.0, -5.0, 0.7), upper(5.0, 5.0, 0.7);
  const BoxMinimum full = minimizeInBox(cost, start, lower, upper, kTight, Deadline::none());
  EXPECT_NEAR((full.x - Eigen::Vector3d(1.0, 1.0, 0.7)).norm(), 0.0, 1e-4);
  const BoxMinimum cut =
      minimizeInBox(cost, start, lower, upper, {.max_evaluations = 5, .relative_tolerance = 1e-12},
                    Deadline::none());
  EXPECT_EQ(cut.report.termination, Termination::IterationLimit);
  EXPECT_LT(cut.report.cost, kCostOfStart);
}

TEST(BoxMinimizer, HonoursADeadlineThatHasPassed)
{
  const KnownMinimum problem(5);
  const BoxMinimum late = minimizeInBox(problem, problem.start, problem.lower, problem.upper,
                                        kTight, Deadline::in(std::chrono::nanoseconds(-1)));
  EXPECT_EQ(late.report.termination, Termination::TimeLimit);
  EXPECT_EQ(late.report.iterations, 1);
  EXPECT_EQ(late.x, problem.start.cwiseMax(problem.lower).cwiseMin(problem.upper));
}

TEST(BoxMinimizer, AnswersTroubleWithAReport)
{
  const VectorXd zero = VectorXd::Zero(3), one = VectorXd::Ones(3);
  const auto run = [&](const slalom::optim::CostFunction& cost)
  { return minimizeInBox(cost, zero, -one, one, {}, Deadline::none()); };
  int calls = 0;
  const auto throws = run(
      [&](const VectorXd& x, VectorXd& gradient) -> double
      {
        if (++calls > 1) throw std::runtime_error("no map");
        gradient = 2.0 * (x - one);
        return (x - one).squaredNorm();
      });
  EXPECT_EQ(throws.report.termination, Termination::NumericalFailure);
  EXPECT_NE(throws.report.message.find("no map"), std::string::npos);
  EXPECT_EQ(throws.x, zero);

  const auto nan =
      run([](const VectorXd&, VectorXd&) { return std::numeric_limits<double>::quiet_NaN(); });
  EXPECT_EQ(nan.report.termination, Termination::NumericalFailure);
  EXPECT_TRUE(nan.x.allFinite());

  const auto quadratic = [](const VectorXd& x, VectorXd& gradient)
  {
    gradient = 2.0 * x;
    return x.squaredNorm();
  };
  EXPECT_EQ(minimizeInBox(quadratic, zero, one, -one, {}, Deadline::none()).report.termination,
            Termination::NumericalFailure);
  EXPECT_EQ(
      minimizeInBox(quadratic, zero, one.head(2), one, {}, Deadline::none()).report.termination,
      Termination::NumericalFailure);
}

}  // namespace
