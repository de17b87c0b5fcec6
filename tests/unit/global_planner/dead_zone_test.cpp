// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "ChainProblems.h"
#include "PathPrograms.h"
#include "SharedData.h"
#include "slalom/geometry/ConvexDecomposition.h"

namespace slalom::global_planner
{
namespace
{
using Eigen::Index;
using test::ChainProblem;

/// Point by point the projections are what a general solver finds for Eq. (5) as a whole.
void expectTheSolutionOfEquation5(optim::IpoptSolver& ipopt, const ChainProblem& problem)
{
  const optim::test::DeadZoneProgram program(problem.points, problem.perPoint());
  const optim::NlpSolution oracle =
      ipopt.solve(program, {problem.points.reshaped(), {}, {}, {}}, core::Deadline::none());
  ASSERT_TRUE(oracle.report.converged()) << oracle.report.message;
  const Eigen::Matrix3Xd expected = oracle.point.x.reshaped(3, problem.points.cols());
  double cost = 0.0, expected_cost = 0.0;
  for (Index j = 0; j < problem.points.cols(); ++j)
  {
    const auto& set = problem.sets[problem.owner[static_cast<std::size_t>(j)]];
    const auto found = geometry::project(problem.points.col(j), set);
    ASSERT_TRUE(found.has_value());
    EXPECT_LE(set.violation(*found), 1e-8);
    EXPECT_LE((*found - expected.col(j)).norm(), 1e-3);
    cost += (*found - problem.points.col(j)).norm();
    expected_cost += (expected.col(j) - problem.points.col(j)).norm();
  }
  EXPECT_NEAR(cost, expected_cost, 1e-4 * (1.0 + cost));
}

optim::IpoptConfig oracleConfig()
{
  return {.tolerance = 1e-8, .max_iterations = 300, .initial_barrier = 0.1};
}

TEST(DeadZone, ProjectionsSolveSeededProblems)
{
  optim::IpoptSolver ipopt(oracleConfig());
  for (std::uint64_t seed = 1; seed <= 100; ++seed)
  {
    SCOPED_TRACE(seed);
    expectTheSolutionOfEquation5(ipopt, test::makeChainProblem(seed, 20, 1 + seed % 4, 14));
  }
}

TEST(DeadZone, ProjectionsSolveTheMeasuredInstances)
{
  const auto file = test::sharedData("problems/socp_dead_k0_n40_m20.txt");
  if (!exists(file)) GTEST_SKIP() << "no evaluation data: " << file;
  optim::IpoptSolver ipopt(oracleConfig());
  const auto problems = test::readChainProblems(file);
  ASSERT_EQ(problems.size(), 60u);
  for (const ChainProblem& problem : problems)
  {
    SCOPED_TRACE(problem.id);
    expectTheSolutionOfEquation5(ipopt, problem);
  }
}

}  // namespace
}  // namespace slalom::global_planner
