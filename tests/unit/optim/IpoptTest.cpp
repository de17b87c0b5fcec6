// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <stdexcept>
#include <thread>

#include "NlpCheck.h"
#include "slalom/core/Rng.h"
#include "slalom/optim/Ipopt.h"

namespace
{
using Eigen::Ref;
using Eigen::VectorXd;
using slalom::core::Deadline;
using slalom::core::Rng;
using slalom::core::Termination;
using namespace slalom::optim;

/// Problem 71 of Hock and Schittkowski: x1 x4 (x1+x2+x3) + x3 with a product >= 25 and a sphere.
class Hs71 : public NonlinearProgram
{
 public:
  double product = 25.0, sphere = 40.0, upper = 5.0;
  bool broken = false;

  int variables() const override { return 4; }
  int constraints() const override { return 2; }
  void bounds(Ref<VectorXd> xl, Ref<VectorXd> xu, Ref<VectorXd> gl, Ref<VectorXd> gu) const override
  {
    xl.setConstant(1.0);
    xu.setConstant(upper);
    gl << product, sphere;
    gu << 2e19, sphere;
  }
  std::vector<Entry> jacobianStructure() const override
  {
    return {{0, 0}, {0, 1}, {0, 2}, {0, 3}, {1, 0}, {1, 1}, {1, 2}, {1, 3}};
  }
  std::vector<Entry> hessianStructure() const override
  {
    return {{0, 0}, {1, 0}, {1, 1}, {2, 0}, {2, 1}, {2, 2}, {3, 0}, {3, 1}, {3, 2}, {3, 3}};
  }
  double cost(const Ref<const VectorXd>& x) const override
  {
    if (broken) throw std::runtime_error("broken on purpose");
    return x[0] * x[3] * (x[0] + x[1] + x[2]) + x[2];
  }
  void gradient(const Ref<const VectorXd>& x, Ref<VectorXd> g) const override
  {
    const double s = x[0] + x[1] + x[2];
    g << x[3] * (s + x[0]), x[0] * x[3], x[0] * x[3] + 1.0, x[0] * s;
  }
  void constraint(const Ref<const VectorXd>& x, Ref<VectorXd> g) const override
  {
    g << x.prod(), x.squaredNorm();
  }
  void jacobian(const Ref<const VectorXd>& x, Ref<VectorXd> v) const override
  {
    v << x[1] * x[2] * x[3], x[0] * x[2] * x[3], x[0] * x[1] * x[3], x[0] * x[1] * x[2], 2 * x[0],
        2 * x[1], 2 * x[2], 2 * x[3];
  }
  void hessian(const Ref<const VectorXd>& x, double sigma, const Ref<const VectorXd>& lambda,
               Ref<VectorXd> v) const override
  {
    const double p = lambda[0], q = 2.0 * lambda[1];
    v << sigma * 2 * x[3] + q, sigma * x[3] + p * x[2] * x[3], q, sigma * x[3] + p * x[1] * x[3],
        p * x[0] * x[3], q, sigma * (2 * x[0] + x[1] + x[2]) + p * x[1] * x[2],
        sigma * x[0] + p * x[0] * x[2], sigma * x[0] + p * x[0] * x[1], q;
  }
};

const NlpPoint kStart{Eigen::Vector4d(1.0, 5.0, 5.0, 1.0), {}, {}, {}};
const Eigen::Vector4d kSolution(1.0, 4.74299964, 3.82114998, 1.37940829);
constexpr double kCost = 17.0140173;

/// Every law holds with both linear solvers.
class Ipopt : public testing::TestWithParam<KktSolver>
{
 protected:
  static IpoptConfig with(IpoptConfig config)
  {
    config.kkt_solver = GetParam();
    return config;
  }
};
INSTANTIATE_TEST_SUITE_P(Kkt, Ipopt, testing::Values(KktSolver::Ldlt, KktSolver::Mumps),
                         [](const auto& one)
                         { return one.param == KktSolver::Ldlt ? "Ldlt" : "Mumps"; });

TEST(Hs71, HasExactDerivatives)
{
  Rng rng(3);
  for (int i = 0; i < 20; ++i)
  {
    const VectorXd x = Eigen::Vector4d::NullaryExpr([&] { return rng.uniform(1.0, 5.0); });
    slalom::test::expectExactDerivatives(Hs71(), x, rng.uniform(0.0, 2.0),
                                         Eigen::Vector2d(rng.normal(), rng.normal()));
  }
}

TEST_P(Ipopt, FindsTheKnownSolutionWithTrueResiduals)
{
  IpoptSolver solver(with({.tolerance = 1e-8, .initial_barrier = 0.1}));
  testing::internal::CaptureStdout();
  const NlpSolution found = solver.solve(Hs71(), kStart, Deadline::none());
  EXPECT_EQ(testing::internal::GetCapturedStdout(), "");
  ASSERT_TRUE(found.report.converged()) << found.report.message;
  EXPECT_LE((found.point.x - kSolution).norm(), 1e-5);
  EXPECT_NEAR(found.report.cost, kCost, 1e-5);
  EXPECT_LE(found.report.primal_residual, 1e-6);
  EXPECT_LE(found.report.dual_residual, 1e-6);
  EXPECT_GT(found.report.iterations, 2);
}

TEST_P(Ipopt, ReuseGivesWhatAFreshSolverGives)
{
  IpoptSolver reused(with({.tolerance = 1e-8, .initial_barrier = 0.1}));
  Rng rng(11);
  for (int i = 0; i < 40; ++i)
  {
    SCOPED_TRACE(i);
    Hs71 program;
    program.product = rng.uniform(10.0, 30.0);
    program.sphere = rng.uniform(36.0, 44.0);
    program.upper = i % 7 == 3 ? 3e19 : rng.uniform(4.9, 5.5);  // also a change of structure
    IpoptSolver fresh(with({.tolerance = 1e-8, .initial_barrier = 0.1}));
    const NlpSolution a = reused.solve(program, kStart, Deadline::none());
    const NlpSolution b = fresh.solve(program, kStart, Deadline::none());
    ASSERT_TRUE(a.report.converged()) << a.report.message;
    ASSERT_TRUE(b.report.converged()) << b.report.message;
    EXPECT_LE((a.point.x - b.point.x).norm(), 1e-6);
  }
}

TEST_P(Ipopt, WarmStartWithMultipliersIsNotSlower)
{
  IpoptSolver solver(with({.tolerance = 1e-6, .initial_barrier = 1e-5, .warm_start = true}));
  const NlpSolution cold = solver.solve(Hs71(), kStart, Deadline::none());
  ASSERT_TRUE(cold.report.converged());
  Hs71 near;
  near.product = 25.01;
  const NlpSolution warm = solver.solve(near, cold.point, Deadline::none());
  ASSERT_TRUE(warm.report.converged()) << warm.report.message;
  EXPECT_LT(warm.report.iterations, cold.report.iterations);
}

TEST_P(Ipopt, HonoursADeadlineThatHasPassed)
{
  IpoptSolver solver(with({}));
  const NlpSolution late = solver.solve(Hs71(), kStart, Deadline::in(std::chrono::nanoseconds(-1)));
  EXPECT_EQ(late.report.termination, Termination::TimeLimit);
  EXPECT_EQ(late.report.iterations, 0);
  EXPECT_TRUE(late.point.x.allFinite());
  // And the solver is as good as new.
  EXPECT_TRUE(solver.solve(Hs71(), kStart, Deadline::none()).report.converged());
}

TEST_P(Ipopt, AnswersTroubleWithAReport)
{
  IpoptSolver solver(with({.max_iterations = 200}));
  Hs71 impossible;
  impossible.product = 1000.0;  // beyond 5^4 = 625
  EXPECT_FALSE(solver.solve(impossible, kStart, Deadline::none()).report.converged());
  Hs71 broken;
  broken.broken = true;
  const NlpSolution failed = solver.solve(broken, kStart, Deadline::none());
  EXPECT_EQ(failed.report.termination, Termination::NumericalFailure);
  EXPECT_NE(failed.report.message.find("broken on purpose"), std::string::npos)
      << failed.report.message;
  const NlpPoint garbage{VectorXd::Constant(4, std::nan("")), {}, {}, {}};
  EXPECT_EQ(solver.solve(Hs71(), garbage, Deadline::none()).report.termination,
            Termination::NumericalFailure);
  EXPECT_TRUE(solver.solve(Hs71(), kStart, Deadline::none()).report.converged());
}

TEST_P(Ipopt, ContradictoryBoundsAreInfeasibleAndNoCrash)
{
  Hs71 program;
  program.upper = 0.5;  // below the lower bounds
  IpoptSolver solver(with({}));
  const NlpSolution found = solver.solve(program, kStart, Deadline::none());
  EXPECT_EQ(found.report.termination, Termination::Infeasible) << found.report.message;
  EXPECT_TRUE(found.point.x.allFinite());
}

TEST_P(Ipopt, TwoThreadsMaySolveAtOnce)
{
  int converged[2] = {0, 0};
  {
    std::vector<std::jthread> threads;
    for (int& count : converged)
      threads.emplace_back(
          [&count]
          {
            for (int i = 0; i < 20; ++i)
            {
              IpoptSolver solver(with({}));  // construction and destruction are part of the law
              for (int k = 0; k < 3; ++k)
                count += solver.solve(Hs71(), kStart, Deadline::none()).report.converged();
            }
          });
  }
  EXPECT_EQ(converged[0], 60);
  EXPECT_EQ(converged[1], 60);
}

}  // namespace
