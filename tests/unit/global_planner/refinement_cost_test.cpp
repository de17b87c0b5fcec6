// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "RandomRefinement.h"
#include "slalom/global_planner/RefinementCost.h"

namespace slalom::global_planner::test
{
namespace
{
TEST(ClearancePenalty, DerivativesMatchDifferences)
{
  core::Rng rng(1);
  for (int k = 0; k < 4000; ++k)
  {
    const Push push{0, rng.uniform3(-1, 1), rng.direction()};
    const Eigen::Vector3d p = push.anchor_L + rng.uniform3(-2, 2);
    const double clearance = rng.uniform(0.1, 1.5), h = 1e-6;
    const HingeTail tail = k % 2 ? HingeTail::Cubic : HingeTail::Quadratic;
    const auto at = [&](const Eigen::Vector3d& step)
    { return clearancePenalty(p + step, push, clearance, tail); };
    const Penalty penalty = at(Eigen::Vector3d::Zero());
    for (int axis = 0; axis < 3; ++axis)
    {
      const Eigen::Vector3d step = h * Eigen::Vector3d::Unit(axis);
      const double n = push.normal_L[axis];
      const double slope = (at(step).cost - at(-step).cost) / (2.0 * h);
      EXPECT_NEAR(penalty.slope * n, slope, 1e-5 * (1.0 + std::abs(slope)));
      const double curvature = (at(step).slope - at(-step).slope) / (2.0 * h);
      EXPECT_NEAR(penalty.curvature * n, curvature, 1e-5 * (1.0 + std::abs(curvature)));
    }
  }
}

TEST(ClearancePenalty, JoinsItsBranchesTwiceContinuously)
{
  const Push push{0, Eigen::Vector3d::Zero(), Eigen::Vector3d::UnitX()};
  const double clearance = 0.8, tiny = 1e-9;
  // e = clearance at the anchor (cubic to quadratic), e = 0 at the clearance (to zero).
  for (const double x : {0.0, clearance})
  {
    const auto at = [&](double dx)
    { return clearancePenalty(Eigen::Vector3d(x + dx, 0, 0), push, clearance); };
    EXPECT_NEAR(at(-tiny).cost, at(tiny).cost, 1e-8);
    EXPECT_NEAR(at(-tiny).slope, at(tiny).slope, 1e-7);
    EXPECT_NEAR(at(-tiny).curvature, at(tiny).curvature, 1e-7);
  }
}

/// J written from the equations alone, for comparison.
double plainJ(const RefinementCost::Problem& problem, const Eigen::Matrix3Xd& c,
              const GlobalPlannerConfig& config, const core::Vehicle& vehicle)
{
  const double d = problem.knot_span;
  const auto over = [](double x, double limit)
  { return std::pow(std::max(0.0, std::abs(x) - limit), 2); };
  double smooth = 0.0, feasible = 0.0, obstacles = 0.0, fit = 0.0;
  for (Eigen::Index i = 0; i + 1 < c.cols(); ++i)
    for (int axis = 0; axis < 3; ++axis)
    {
      feasible += over((c(axis, i + 1) - c(axis, i)) / d, vehicle.max_speed_mps) / (d * d);
      if (i + 2 >= c.cols()) continue;
      const double bend = c(axis, i + 2) - 2.0 * c(axis, i + 1) + c(axis, i);
      smooth += bend * bend;
      feasible += over(bend / (d * d), vehicle.max_acceleration_mps2);
    }
  for (const Push& push : problem.pushes)
    obstacles += clearancePenalty(c.col(push.point), push, config.clearance_m, problem.tail).cost;
  for (Eigen::Index i = 1; i + 1 < c.cols(); ++i)
  {
    const Eigen::Matrix3Xd offset = c.middleCols(i - 1, 3) - problem.reference.middleCols(i - 1, 3);
    const Eigen::Vector3d x = (offset.col(0) + 4.0 * offset.col(1) + offset.col(2)) / 6.0;
    const Eigen::Vector3d t =
        (problem.reference.col(i + 1) - problem.reference.col(i - 1)).normalized();
    fit += problem.fit_weight[i] * (std::pow(x.dot(t), 2) / 25.0 + x.cross(t).squaredNorm());
  }
  return config.lambda_smooth * smooth + config.lambda_obs * problem.obstacle_gain * obstacles +
         config.lambda_feas * feasible + config.lambda_fit * fit;
}

TEST(RefinementCost, IsTheSumOfItsEquations)
{
  for (std::uint64_t seed = 0; seed < 300; ++seed)
  {
    SCOPED_TRACE(seed);
    core::Rng rng(seed);
    const RefinementCost::Problem problem = randomProblem(rng);
    RefinementCost cost(problem, GlobalPlannerConfig{}, core::Vehicle{});
    Eigen::VectorXd gradient;
    const double expected = plainJ(problem, problem.points, GlobalPlannerConfig{}, core::Vehicle{});
    EXPECT_NEAR(cost.evaluate(cost.start(), gradient), expected, 1e-10 * (1.0 + expected));
  }
}

/// A J whose derivatives are compared with differences along a random direction.
struct Probe
{
  explicit Probe(std::uint64_t seed) : rng(seed), problem(randomProblem(rng)) {}
  void check()
  {
    RefinementCost cost(problem, GlobalPlannerConfig{}, core::Vehicle{});
    const Eigen::VectorXd x = cost.start();
    const Eigen::VectorXd direction =
        Eigen::VectorXd::NullaryExpr(x.size(), [&] { return rng.normal(); }).normalized();
    Eigen::VectorXd gradient, ahead, behind;
    EXPECT_GE(cost.evaluate(x, gradient), 0.0);
    const double slope =
        (cost.evaluate(x + h * direction, ahead) - cost.evaluate(x - h * direction, behind)) /
        (2.0 * h);
    EXPECT_NEAR(gradient.dot(direction), slope, 1e-5 * (1.0 + gradient.norm()));

    Eigen::ArrayXd d;
    cost.limits().differences(x, d);
    const Eigen::ArrayXd to_limit = (d.abs() - cost.limits().limit()).abs();
    near += (to_limit < 100.0 * h).any();
    if ((to_limit < 4.0 * h).any()) return;  // the curvature jumps between the two points
    ++curved;
    optim::BlockBand hessian(x.size() / 3);
    cost.curvature(x, hessian);
    const Eigen::VectorXd expected = (ahead - behind) / (2.0 * h);
    EXPECT_NEAR((hessian.times(direction.reshaped(3, x.size() / 3)).reshaped() - expected).norm(),
                0.0, 1e-5 * (1.0 + expected.norm()));
  }
  static constexpr double h = 1e-6;
  core::Rng rng;
  RefinementCost::Problem problem;
  int near = 0, curved = 0;
};

TEST(RefinementCost, DerivativesMatchDifferences)
{
  int curved = 0;
  for (std::uint64_t seed = 0; seed < 500; ++seed)
  {
    SCOPED_TRACE(seed);
    Probe probe(seed);
    probe.check();
    curved += probe.curved;
  }
  EXPECT_GE(curved, 400);
}

TEST(RefinementCost, DerivativesMatchDifferencesBesideEveryJoint)
{
  // One free point is moved until its speed, its acceleration or its push is just before or just
  // behind the joint of two branches, farther from it than the differences reach.
  int near = 0, curved = 0;
  for (std::uint64_t seed = 0; seed < 600; ++seed)
  {
    SCOPED_TRACE(seed);
    Probe probe(seed);
    const core::Vehicle vehicle;
    const double clearance = GlobalPlannerConfig{}.clearance_m, d = probe.problem.knot_span;
    const double aside = (probe.rng.integer(0, 1) ? 1.0 : -1.0) * 20.0 * Probe::h;
    Eigen::Matrix3Xd& c = probe.problem.points;
    const int axis = probe.rng.integer(0, 2);
    switch (seed % 4)
    {
      case 0:
        c(axis, 4) = c(axis, 3) - vehicle.max_speed_mps * d + aside;
        break;
      case 1:
        c(axis, 4) = 2.0 * c(axis, 3) - c(axis, 2) + vehicle.max_acceleration_mps2 * d * d + aside;
        break;
      default:
      {
        const double e = seed % 4 == 2 ? 0.0 : clearance;  // to zero; to the tail
        const Eigen::Vector3d normal = probe.rng.direction();
        probe.problem.pushes.push_back({4, c.col(4) - (clearance - e + aside) * normal, normal});
      }
    }
    probe.check();
    near += probe.near, curved += probe.curved;
  }
  EXPECT_GE(near, 250);  // the cases of speed and acceleration
  EXPECT_GE(curved, 550);
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
  EXPECT_NEAR(cost.evaluate(cost.start(), gradient), 0.0, 1e-20);
  EXPECT_NEAR(gradient.norm(), 0.0, 1e-12);
}

}  // namespace
}  // namespace slalom::global_planner::test
