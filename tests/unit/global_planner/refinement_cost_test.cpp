// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "slalom/core/Rng.h"
#include "slalom/global_planner/RefinementCost.h"

namespace slalom::global_planner
{
namespace
{
RefinementCost::Problem randomProblem(core::Rng& rng)
{
  RefinementCost::Problem problem;
  const Eigen::Index n = rng.integer(9, 40);
  problem.points.resize(3, n);
  problem.reference.resize(3, n);
  problem.fit_weight.resize(n);
  Eigen::Vector3d p = rng.uniform3(-2.0, 2.0);
  for (Eigen::Index i = 0; i < n; ++i)
  {
    p += rng.uniform3(-0.4, 0.4);
    problem.reference.col(i) = p;
    problem.points.col(i) = p + rng.uniform3(-0.5, 0.5);
    problem.fit_weight[i] = rng.integer(0, 1);
  }
  problem.first_free = 4;
  problem.last_free = n - 4;
  problem.knot_span = rng.uniform(0.1, 0.4);
  problem.obstacle_gain = rng.uniform(1.0, 4.0);
  for (int k = rng.integer(0, 20); k > 0; --k)
  {
    const Eigen::Index i = rng.integer(4, static_cast<int>(n) - 4);
    problem.pushes.push_back({i, problem.points.col(i) + rng.uniform3(-1.5, 1.5), rng.direction()});
  }
  return problem;
}

TEST(ClearancePenalty, GradientMatchesDifferences)
{
  core::Rng rng(1);
  for (int k = 0; k < 2000; ++k)
  {
    const Push push{0, rng.uniform3(-1, 1), rng.direction()};
    const Eigen::Vector3d p = push.anchor_L + rng.uniform3(-2, 2);
    const double clearance = rng.uniform(0.1, 1.5), h = 1e-6;
    const Penalty penalty = clearancePenalty(p, push, clearance);
    for (int axis = 0; axis < 3; ++axis)
    {
      const Eigen::Vector3d step = h * Eigen::Vector3d::Unit(axis);
      const double difference = (clearancePenalty(p + step, push, clearance).cost -
                                 clearancePenalty(p - step, push, clearance).cost) /
                                (2.0 * h);
      EXPECT_NEAR(penalty.gradient[axis], difference, 1e-5 * (1.0 + std::abs(difference)));
    }
  }
}

TEST(ClearancePenalty, JoinsItsBranchesTwiceContinuously)
{
  const Push push{0, Eigen::Vector3d::Zero(), Eigen::Vector3d::UnitX()};
  const double clearance = 0.8, tiny = 1e-7;
  // e = clearance at the anchor (cubic to quadratic), e = 0 at the clearance (to zero).
  for (const double x : {0.0, clearance})
  {
    const auto at = [&](double dx)
    { return clearancePenalty(Eigen::Vector3d(x + dx, 0, 0), push, clearance); };
    EXPECT_NEAR(at(-tiny).cost, at(tiny).cost, 1e-5);
    EXPECT_NEAR(at(-tiny).gradient.x(), at(tiny).gradient.x(), 1e-5);
    const double h = 1e-4;
    const double curvature_left = (at(-2 * h).cost - 2 * at(-h).cost + at(0).cost) / (h * h);
    const double curvature_right = (at(0).cost - 2 * at(h).cost + at(2 * h).cost) / (h * h);
    EXPECT_NEAR(curvature_left, curvature_right, 5e-3);
  }
}

TEST(RefinementCost, GradientMatchesDifferences)
{
  for (std::uint64_t seed = 0; seed < 300; ++seed)
  {
    SCOPED_TRACE(seed);
    core::Rng rng(seed);
    RefinementCost cost(randomProblem(rng), GlobalPlannerConfig{}, core::Vehicle{});
    const Eigen::VectorXd x = cost.start();
    Eigen::VectorXd gradient, unused;
    const double value = cost(x, gradient);
    EXPECT_GE(value, 0.0);
    const Eigen::VectorXd direction =
        Eigen::VectorXd::NullaryExpr(x.size(), [&] { return rng.normal(); }).normalized();
    const double h = 1e-6;
    const double difference =
        (cost(x + h * direction, unused) - cost(x - h * direction, unused)) / (2.0 * h);
    EXPECT_NEAR(gradient.dot(direction), difference, 1e-5 * (1.0 + gradient.norm()));
  }
}

TEST(RefinementCost, IsZeroOnAStraightUnhurriedReference)
{
  RefinementCost::Problem problem;
  problem.points.resize(3, 20);
  for (Eigen::Index i = 0; i < 20; ++i)
    problem.points.col(i) = Eigen::Vector3d(0.1 * double(i), 0, 1);
  problem.reference = problem.points;
  problem.fit_weight = Eigen::VectorXd::Ones(20);
  problem.first_free = 4;
  problem.last_free = 16;
  RefinementCost cost(problem, GlobalPlannerConfig{}, core::Vehicle{});
  Eigen::VectorXd gradient;
  EXPECT_NEAR(cost(cost.start(), gradient), 0.0, 1e-20);
  EXPECT_NEAR(gradient.norm(), 0.0, 1e-12);
}

}  // namespace
}  // namespace slalom::global_planner
