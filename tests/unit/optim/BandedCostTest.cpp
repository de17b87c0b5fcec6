// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "BandedProblems.h"

namespace slalom::optim::test
{
namespace
{
using core::Rng;
using Eigen::ArrayXd;
using Eigen::Index;
using Eigen::VectorXd;

VectorXd randomVector(Rng& rng, Index n)
{
  return VectorXd::NullaryExpr(n, [&] { return rng.normal(); });
}

/// The price of limits, written from their definition over all points.
double priceOf(const Eigen::Matrix3Xd& path, const std::vector<SoftLimits::Limit>& limits)
{
  double price = 0.0;
  const auto over = [](double d, double limit) { return std::max(0.0, std::abs(d) - limit); };
  for (const SoftLimits::Limit& limit : limits)
    for (Index axis = 0; axis < 3; ++axis)
      for (Index i = 0; i + limit.order < path.cols(); ++i)
      {
        const double d = limit.order == 1
                             ? path(axis, i + 1) - path(axis, i)
                             : path(axis, i + 2) - 2.0 * path(axis, i + 1) + path(axis, i);
        price += limit.weight * std::pow(over(d, limit.limit), 2);
      }
  return price;
}

struct OnlyLimits final : LimitedCost
{
  using LimitedCost::LimitedCost;
  double evaluateSmooth(const VectorXd&, VectorXd& gradient) override
  {
    gradient.setZero();
    return 0.0;
  }
  void curvatureSmooth(const VectorXd&, BlockBand& hessian) override { hessian.setZero(); }
};

TEST(SoftLimits, PriceIsTheOneOfTheDefinition)
{
  for (std::uint64_t seed = 1; seed <= 500; ++seed)
  {
    SCOPED_TRACE(seed);
    Rng rng(seed);
    const Index before = rng.integer(0, 4), points = rng.integer(1, 12), behind = rng.integer(0, 4);
    Eigen::Matrix3Xd path(3, before + points + behind);
    for (double& value : path.reshaped()) value = rng.uniform(-1.0, 1.0);
    const std::vector<SoftLimits::Limit> limits{{1, rng.uniform(0.1, 1.0), rng.uniform(0.0, 3.0)},
                                                {2, rng.uniform(0.1, 1.0), rng.uniform(0.0, 3.0)}};
    OnlyLimits cost(SoftLimits(path.leftCols(before), points, path.rightCols(behind), limits));
    VectorXd gradient(3 * points);
    const VectorXd x = path.middleCols(before, points).reshaped();
    const double price = priceOf(path, limits);
    EXPECT_NEAR(cost.evaluate(x, gradient), price, 1e-12 * (1.0 + price));
  }
}

TEST(SoftLimits, ForceAndStiffnessBelongToTheDifferences)
{
  for (std::uint64_t seed = 1; seed <= 200; ++seed)
  {
    SCOPED_TRACE(seed);
    const LimitedProblem problem(seed);
    const SoftLimits& limits = problem.limits();
    Rng rng(seed);
    const Index n = problem.start.size();
    const VectorXd x = randomVector(rng, n), dx = randomVector(rng, n);
    ArrayXd at, moved, change;
    limits.differences(x, at);
    limits.differences(x + dx, moved);
    limits.changes(dx, change);
    EXPECT_NEAR((moved - at - change).matrix().norm(), 0.0, 1e-12 * (1.0 + change.matrix().norm()));

    const ArrayXd force = randomVector(rng, limits.rows()).array();
    VectorXd pulled = VectorXd::Zero(n);
    limits.addForce(force, pulled);
    EXPECT_NEAR(pulled.dot(dx), (force * change).sum(), 1e-10 * (1.0 + force.matrix().norm()));

    const ArrayXd stiffness = force.abs();
    BlockBand hessian(n / 3);
    limits.addStiffness(stiffness, hessian);
    VectorXd expected = VectorXd::Zero(n);
    limits.addForce(stiffness * change, expected);
    EXPECT_NEAR((hessian.times(dx.reshaped(3, n / 3)).reshaped() - expected).norm(), 0.0,
                1e-10 * (1.0 + expected.norm()));
  }
}

TEST(LimitedCost, DerivativesMatchDifferences)
{
  int curved = 0;
  for (std::uint64_t seed = 1; seed <= 300; ++seed)
  {
    SCOPED_TRACE(seed);
    LimitedProblem problem(seed);
    Rng rng(seed);
    const VectorXd x = problem.start;
    const Index n = x.size();
    const VectorXd direction = randomVector(rng, n).normalized();
    const double h = 1e-6;
    VectorXd here(n), ahead(n), behind(n);
    (void)problem.evaluate(x, here);
    const double slope =
        (problem.evaluate(x + h * direction, ahead) - problem.evaluate(x - h * direction, behind)) /
        (2.0 * h);
    EXPECT_NEAR(here.dot(direction), slope, 1e-6 * (1.0 + here.norm()));

    // The curvature jumps at a limit; beside the jump it must match from both sides of it.
    ArrayXd d;
    problem.limits().differences(x, d);
    if (((d.abs() - problem.limits().limit()).abs() < 5.0 * h).any()) continue;
    ++curved;
    BlockBand hessian(n / 3);
    problem.curvature(x, hessian);
    const VectorXd expected = (ahead - behind) / (2.0 * h);
    EXPECT_NEAR((hessian.times(direction.reshaped(3, n / 3)).reshaped() - expected).norm(), 0.0,
                1e-5 * (1.0 + expected.norm()));
  }
  EXPECT_GE(curved, 250);
}

}  // namespace
}  // namespace slalom::optim::test
