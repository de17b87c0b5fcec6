// SPDX-License-Identifier: BSD-3-Clause
// What the second-order method promises beyond the laws of every method (BoxMinimizerTest.cpp).
#include <gtest/gtest.h>

#include <limits>

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
constexpr BoxMinimizerConfig kTight{.max_evaluations = 300, .relative_tolerance = 1e-12};

TEST(BoxNewton, AgreesWithLbfgsOnLimitedProblems)
{
  int active = 0, over = 0;
  for (std::uint64_t seed = 1; seed <= 2000; ++seed)
  {
    SCOPED_TRACE(seed);
    LimitedProblem problem(seed);
    const BoxMinimum newton = minimizeInBox(problem, problem.start, problem.lower, problem.upper,
                                            kTight, Deadline::none());
    EXPECT_TRUE(newton.report.converged()) << newton.report.message;
    const BoxMinimum lbfgs = minimizeInBox(
        problem, problem.start, problem.lower, problem.upper,
        {.method = BoxMethod::Lbfgs, .max_evaluations = 20000, .relative_tolerance = 1e-13},
        Deadline::none());
    EXPECT_NEAR(newton.report.cost, lbfgs.report.cost, 1e-6 * lbfgs.report.cost + 1e-12);
    EXPECT_LE(newton.report.dual_residual, 1e-4 * (1.0 + newton.report.cost));
    active +=
        ((newton.x.array() <= problem.lower.array()) || (newton.x.array() >= problem.upper.array()))
            .any();
    Eigen::ArrayXd d;
    problem.limits().differences(newton.x, d);
    over += (d.abs() > problem.limits().limit()).any();
  }
  // The law would say little about problems without active bounds or exceeded limits.
  EXPECT_GE(active, 1000);
  EXPECT_GE(over, 1000);
}

TEST(BoxNewton, MoreEvaluationsNeverGiveAHigherCost)
{
  for (std::uint64_t seed = 1; seed <= 100; ++seed)
  {
    SCOPED_TRACE(seed);
    LimitedProblem problem(seed);
    double before = kInfinity;
    VectorXd gradient(problem.start.size());
    const double at_start =
        problem.evaluate(problem.start.cwiseMax(problem.lower).cwiseMin(problem.upper), gradient);
    for (int evaluations = 1; evaluations <= 40; ++evaluations)
    {
      const BoxMinimum found = minimizeInBox(
          problem, problem.start, problem.lower, problem.upper,
          {.max_evaluations = evaluations, .relative_tolerance = 1e-12}, Deadline::none());
      EXPECT_LE(found.evaluations, evaluations);
      if (evaluations == 1)
      {
        EXPECT_EQ(found.report.cost, at_start);
      }
      EXPECT_LE(found.report.cost, before);
      EXPECT_NEAR(problem.evaluate(found.x, gradient), found.report.cost,
                  1e-12 * std::abs(found.report.cost));
      before = found.report.cost;
    }
  }
}

TEST(BoxNewton, GoesToTheCornerOfALinearCost)
{
  Rng rng(3);
  const VectorXd slope = VectorXd::NullaryExpr(12, [&] { return rng.normal(); });
  FunctionCost linear([&](const VectorXd& x, VectorXd& gradient)
                      { return gradient = slope, slope.dot(x); });
  const VectorXd one = VectorXd::Ones(12);
  const BoxMinimum corner = minimizeInBox(linear, 0.3 * one, -one, one, kTight, Deadline::none());
  EXPECT_TRUE(corner.report.converged()) << corner.report.message;
  EXPECT_NEAR(corner.report.cost, -slope.lpNorm<1>(), 1e-9);

  // Without a corner there is no minimum, and nobody may claim one.
  const BoxMinimum endless =
      minimizeInBox(linear, 0.3 * one, -kInfinity * one, kInfinity * one, kTight, Deadline::none());
  EXPECT_FALSE(endless.report.converged());
  EXPECT_TRUE(endless.x.allFinite());
}

TEST(BoxNewton, SolvesDegenerateProblems)
{
  const VectorXd one = VectorXd::Ones(9);
  FunctionCost nothing([](const VectorXd&, VectorXd& gradient) { return gradient.setZero(), 0.0; });
  const BoxMinimum idle = minimizeInBox(nothing, 0.5 * one, -one, one, kTight, Deadline::none());
  EXPECT_TRUE(idle.report.converged());
  EXPECT_EQ(idle.x, 0.5 * one);
  EXPECT_EQ(idle.report.dual_residual, 0.0);

  KnownMinimum problem(7);
  const VectorXd start = problem.start.cwiseMax(problem.lower).cwiseMin(problem.upper);
  const BoxMinimum held = minimizeInBox(problem, start, start, start, kTight, Deadline::none());
  EXPECT_TRUE(held.report.converged());
  EXPECT_EQ(held.x, start);
  EXPECT_EQ(held.evaluations, 1);

  // Only the first of three points has any curvature.
  FunctionCost one_of_three(
      [](const VectorXd& x, VectorXd& gradient)
      {
        gradient.setZero();
        gradient.head<3>() = 2.0 * (x.head<3>() - Eigen::Vector3d(0.1, 0.2, 5.0));
        return (x.head<3>() - Eigen::Vector3d(0.1, 0.2, 5.0)).squaredNorm();
      },
      [](const VectorXd&, BlockBand& hessian)
      { hessian.diagonal[0] = 2.0 * Eigen::Matrix3d::Identity(); });
  const BoxMinimum partial = minimizeInBox(one_of_three, -one, -one, one, kTight, Deadline::none());
  EXPECT_TRUE(partial.report.converged());
  EXPECT_NEAR((partial.x.head<3>() - Eigen::Vector3d(0.1, 0.2, 1.0)).norm(), 0.0, 1e-6);
}

TEST(BoxNewton, ReportsACurvatureThatIsNotFinite)
{
  FunctionCost cost([](const VectorXd& x, VectorXd& gradient)
                    { return gradient = 2.0 * x, x.squaredNorm(); },
                    [](const VectorXd&, BlockBand& hessian)
                    { hessian.diagonal[0].setConstant(std::numeric_limits<double>::quiet_NaN()); });
  const VectorXd one = VectorXd::Ones(3);
  const BoxMinimum found = minimizeInBox(cost, 0.5 * one, -one, one, kTight, Deadline::none());
  EXPECT_EQ(found.report.termination, Termination::NumericalFailure);
  EXPECT_EQ(found.x, 0.5 * one);
}

TEST(BoxNewton, RefusesVariablesThatAreNotPoints)
{
  FunctionCost cost([](const VectorXd& x, VectorXd& gradient)
                    { return gradient = 2.0 * x, x.squaredNorm(); });
  const VectorXd one = VectorXd::Ones(4);
  EXPECT_EQ(minimizeInBox(cost, one, -one, one, kTight, Deadline::none()).report.termination,
            Termination::NumericalFailure);
}

}  // namespace
}  // namespace slalom::optim::test
