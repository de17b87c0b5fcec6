// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <limits>
#include <stdexcept>

#include "BandedProblems.h"

namespace slalom::optim::test
{
namespace
{
using core::Deadline;
using core::Rng;
using core::Termination;
using Eigen::VectorXd;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

BoxMinimizerConfig tight(BoxMethod method)
{
  return {.method = method,
          .max_evaluations = method == BoxMethod::Newton ? 300 : 20000,
          .relative_tolerance = method == BoxMethod::Newton ? 1e-12 : 1e-14};
}

class BoxMinimizer : public testing::TestWithParam<BoxMethod>
{
};
INSTANTIATE_TEST_SUITE_P(Both, BoxMinimizer, testing::Values(BoxMethod::Newton, BoxMethod::Lbfgs),
                         [](const auto& given)
                         { return given.param == BoxMethod::Newton ? "Newton" : "Lbfgs"; });

TEST_P(BoxMinimizer, FindsKnownMinimaWithActiveBounds)
{
  for (std::uint64_t seed = 1; seed <= 300; ++seed)
  {
    SCOPED_TRACE(seed);
    KnownMinimum problem(seed);
    const BoxMinimum found = minimizeInBox(problem, problem.start, problem.lower, problem.upper,
                                           tight(GetParam()), Deadline::none());
    EXPECT_TRUE(found.report.converged()) << found.report.message;
    EXPECT_LE((found.x - problem.minimum).lpNorm<Eigen::Infinity>(), 1e-4);
    EXPECT_NEAR(found.report.cost, 1.0, 1e-8);
    EXPECT_LE(found.report.dual_residual, 1e-3);
    EXPECT_EQ(found.report.primal_residual, 0.0);
  }
}

TEST_P(BoxMinimizer, EvaluatesInsideTheBoxAndReturnsTheBestPointSeen)
{
  for (std::uint64_t seed = 1; seed <= 100; ++seed)
  {
    SCOPED_TRACE(seed);
    KnownMinimum problem(seed);
    double best = kInfinity;
    int evaluations = 0;
    FunctionCost watched(
        [&](const VectorXd& x, VectorXd& gradient)
        {
          EXPECT_TRUE((x.array() >= problem.lower.array()).all());
          EXPECT_TRUE((x.array() <= problem.upper.array()).all());
          ++evaluations;
          const double cost = problem.evaluate(x, gradient);
          best = std::min(best, cost);
          return cost;
        },
        [&](const VectorXd& x, BlockBand& hessian) { problem.curvature(x, hessian); });
    const BoxMinimum found =
        minimizeInBox(watched, problem.start, problem.lower, problem.upper,
                      {.method = GetParam(), .max_evaluations = 6}, Deadline::none());
    EXPECT_LE(evaluations, 6);
    EXPECT_EQ(found.evaluations, evaluations);
    EXPECT_EQ(found.report.cost, best);
    VectorXd gradient;
    EXPECT_EQ(problem.evaluate(found.x, gradient), best);
  }
}

TEST_P(BoxMinimizer, KeepsFixedVariablesAndReportsTheIterationLimit)
{
  // Rosenbrock's valley, which is not convex, with one variable held.
  FunctionCost cost(
      [](const VectorXd& x, VectorXd& gradient)
      {
        const double a = 1.0 - x[0], b = x[1] - x[0] * x[0];
        gradient = Eigen::Vector3d(-2.0 * a - 400.0 * x[0] * b, 200.0 * b, 2.0 * x[2]);
        return a * a + 100.0 * b * b + x[2] * x[2];
      },
      [](const VectorXd& x, BlockBand& hessian)
      {
        const double b = x[1] - x[0] * x[0];
        hessian.diagonal[0] << 2.0 + 800.0 * x[0] * x[0] - 400.0 * b, -400.0 * x[0], 0.0,
            -400.0 * x[0], 200.0, 0.0, 0.0, 0.0, 2.0;
      });
  constexpr double kCostOfStart = 24.2 + 0.49;
  const Eigen::Vector3d start(-1.2, 1.0, 0.7), lower(-5.0, -5.0, 0.7), upper(5.0, 5.0, 0.7);
  const BoxMinimum full =
      minimizeInBox(cost, start, lower, upper, tight(GetParam()), Deadline::none());
  EXPECT_NEAR((full.x - Eigen::Vector3d(1.0, 1.0, 0.7)).norm(), 0.0, 1e-4);
  const BoxMinimum cut = minimizeInBox(
      cost, start, lower, upper,
      {.method = GetParam(), .max_evaluations = 5, .relative_tolerance = 1e-12}, Deadline::none());
  EXPECT_EQ(cut.report.termination, Termination::IterationLimit);
  EXPECT_LT(cut.report.cost, kCostOfStart);
}

TEST_P(BoxMinimizer, HonoursADeadlineThatHasPassed)
{
  KnownMinimum problem(5);
  const BoxMinimum late =
      minimizeInBox(problem, problem.start, problem.lower, problem.upper, tight(GetParam()),
                    Deadline::in(std::chrono::nanoseconds(-1)));
  EXPECT_EQ(late.report.termination, Termination::TimeLimit);
  EXPECT_EQ(late.evaluations, 1);
  EXPECT_EQ(late.x, problem.start.cwiseMax(problem.lower).cwiseMin(problem.upper));
}

TEST_P(BoxMinimizer, AnswersTroubleWithAReport)
{
  const VectorXd zero = VectorXd::Zero(3), one = VectorXd::Ones(3);
  const auto run =
      [&](BandedCost& cost, const VectorXd& start, const VectorXd& lower, const VectorXd& upper)
  { return minimizeInBox(cost, start, lower, upper, {.method = GetParam()}, Deadline::none()); };
  const auto second = [](const VectorXd&, BlockBand& hessian)
  { hessian.diagonal[0] = 2.0 * Eigen::Matrix3d::Identity(); };
  int calls = 0;
  FunctionCost throws(
      [&](const VectorXd& x, VectorXd& gradient) -> double
      {
        if (++calls > 1) throw std::runtime_error("no map");
        gradient = 2.0 * (x - one);
        return (x - one).squaredNorm();
      },
      second);
  const BoxMinimum thrown = run(throws, zero, -one, one);
  EXPECT_EQ(thrown.report.termination, Termination::NumericalFailure);
  EXPECT_NE(thrown.report.message.find("no map"), std::string::npos);
  EXPECT_EQ(thrown.x, zero);
  EXPECT_EQ(thrown.report.cost, 3.0);

  FunctionCost nan([](const VectorXd&, VectorXd& gradient)
                   { return gradient.setZero(), std::numeric_limits<double>::quiet_NaN(); });
  const BoxMinimum lost = run(nan, zero, -one, one);
  EXPECT_EQ(lost.report.termination, Termination::NumericalFailure);
  EXPECT_EQ(lost.x, zero);

  // Finite at the start only: the start is the best point there is.
  FunctionCost cliff(
      [&](const VectorXd& x, VectorXd& gradient)
      {
        gradient = 2.0 * (x - one);
        return x == zero ? 3.0 : kInfinity;
      },
      second);
  const BoxMinimum kept = run(cliff, zero, -one, one);
  EXPECT_EQ(kept.report.termination, Termination::NumericalFailure);
  EXPECT_EQ(kept.x, zero);
  EXPECT_EQ(kept.report.cost, 3.0);

  FunctionCost quadratic(
      [](const VectorXd& x, VectorXd& gradient)
      {
        gradient = 2.0 * x;
        return x.squaredNorm();
      },
      second);
  for (const BoxMinimum& misused :
       {run(quadratic, zero, one, -one), run(quadratic, zero, one.head(2), one),
        run(quadratic, VectorXd(), VectorXd(), VectorXd()),
        run(quadratic, zero, -kInfinity * one, -kInfinity * one),
        run(quadratic, zero * std::numeric_limits<double>::quiet_NaN(), -one, one)})
    EXPECT_EQ(misused.report.termination, Termination::NumericalFailure);
}

TEST_P(BoxMinimizer, IsDeterministic)
{
  for (std::uint64_t seed = 1; seed <= 20; ++seed)
  {
    SCOPED_TRACE(seed);
    LimitedProblem problem(seed);
    const auto run = [&]
    {
      return minimizeInBox(problem, problem.start, problem.lower, problem.upper,
                           {.method = GetParam(), .max_evaluations = 300}, Deadline::none());
    };
    const BoxMinimum once = run(), again = run();
    EXPECT_EQ(once.x, again.x);
    EXPECT_EQ(once.evaluations, again.evaluations);
  }
}

}  // namespace
}  // namespace slalom::optim::test
