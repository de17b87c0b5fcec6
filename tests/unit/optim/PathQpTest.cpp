// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <limits>

#include "NlpCheck.h"
#include "PathChains.h"
#include "PathPrograms.h"
#include "slalom/optim/Ipopt.h"

namespace slalom::optim
{
namespace
{
using core::Deadline;
using core::Rng;
using core::Termination;
using test::Chain;
using test::halfSpace;
using test::HalfSpaces;
using test::Index;
using test::Matrix3Xd;
using test::Vector3d;
using test::VectorXd;
using test::violation;

double objective(const PathQp& q, const Matrix3Xd& p)
{
  const Index n = p.cols() - 1;
  double cost =
      q.w_start * (p.col(0) - q.first).squaredNorm() + q.w_end * (p.col(n) - q.last).squaredNorm();
  for (Index k = 0; k < n; ++k) cost += q.w_length * (p.col(k + 1) - p.col(k)).squaredNorm();
  for (Index k = 1; k < n; ++k)
    cost += q.w_bend * (p.col(k + 1) - 2 * p.col(k) + p.col(k - 1)).squaredNorm();
  if (q.margin > 0.0)
    for (Index k = 0; k <= n && !q.sets.empty(); ++k)
      for (const HalfSpaces* set : q.sets[k])
        cost +=
            q.w_slack * ((set->A * p.col(k) - set->b).array() + q.margin).max(0.0).square().sum();
  return cost;
}

/// Gradient of the objective by exact differences of a quadratic (piecewise) function.
Matrix3Xd gradientOf(const PathQp& q, const Matrix3Xd& p)
{
  Matrix3Xd gradient(3, p.cols());
  constexpr double h = 1e-6;
  for (Index i = 0; i < p.size(); ++i)
  {
    Matrix3Xd up = p, down = p;
    up(i) += h;
    down(i) -= h;
    gradient(i) = (objective(q, up) - objective(q, down)) / (2.0 * h);
  }
  return gradient;
}

/// Stationarity without the solver's multipliers: -gradient lies in the cone of the active rows.
double stationarityGap(const PathQp& q, const Matrix3Xd& p)
{
  const Matrix3Xd gradient = gradientOf(q, p);
  double worst = 0.0;
  for (Index k = 0; k < p.cols(); ++k)
  {
    Matrix3Xd active(3, 0);
    for (const HalfSpaces* set : q.sets[k])
      for (Index i = 0; i < set->rows(); ++i)
        if (set->A.row(i).dot(p.col(k)) > set->b[i] - 1e-5)
        {
          active.conservativeResize(3, active.cols() + 1);
          active.rightCols(1) = set->A.row(i).transpose();
        }
    worst = std::max(worst, test::distanceFromCone(-gradient.col(k), active));
  }
  return worst;
}

TEST(PathQp, KktConditionsHoldOnThousandsOfChains)
{
  int with_active_rows = 0;
  for (std::uint64_t seed = 1; seed <= 2500; ++seed)
  {
    SCOPED_TRACE(seed);
    const Chain chain(seed);
    const PathQpSolution found = solve(chain.qp, {.max_iterations = 80, .tolerance = 1e-10});
    ASSERT_TRUE(found.report.converged())
        << found.report.message << " after " << found.report.iterations;
    EXPECT_LE(violation(chain.qp.sets, found.points), 1e-7);
    EXPECT_LE(found.report.primal_residual, 1e-7);
    EXPECT_LE(stationarityGap(chain.qp, found.points), 1e-3);
    EXPECT_NEAR(found.report.cost, objective(chain.qp, found.points),
                1e-6 * (1.0 + found.report.cost));
    with_active_rows += violation(chain.qp.sets, found.points) > -1e-6;
  }
  EXPECT_GT(with_active_rows, 500);  // the generator must not make it easy
}

TEST(PathQp, CostEqualsAnIndependentSolution)
{
  for (std::uint64_t seed = 5001; seed <= 5200; ++seed)
  {
    SCOPED_TRACE(seed);
    Chain chain(seed);
    chain.qp.margin = std::max(chain.qp.margin, 0.05);  // a slack fixed at zero has no interior
    const test::QuadraticProgram program(chain.qp);
    NlpPoint start{VectorXd::Zero(program.variables()), {}, {}, {}};
    if (seed < 5010)
      slalom::test::expectExactDerivatives(program, start.x, 1.0,
                                           VectorXd::Ones(program.constraints()), 1e-5);
    IpoptSolver ipopt({.tolerance = 1e-8, .max_iterations = 300, .initial_barrier = 0.1});
    const NlpSolution oracle = ipopt.solve(program, start, Deadline::none());
    ASSERT_TRUE(oracle.report.converged()) << oracle.report.message;
    ASSERT_LE(oracle.report.primal_residual, 1e-7);  // by PathProgram's own functions
    ASSERT_LE(oracle.report.dual_residual, 1e-5);
    const PathQpSolution found = solve(chain.qp);
    ASSERT_TRUE(found.report.converged()) << found.report.message;
    EXPECT_NEAR(found.report.cost, oracle.report.cost, 1e-5 * (1.0 + oracle.report.cost));
    const Matrix3Xd p = oracle.point.x.head(3 * chain.qp.points).reshaped(3, chain.qp.points);
    EXPECT_LE((found.points - p).cwiseAbs().maxCoeff(), 2e-3);
  }
}

TEST(PathQp, ContradictionsAreReportedWithTheLeastViolatingPath)
{
  for (std::uint64_t seed = 1; seed <= 300; ++seed)
  {
    SCOPED_TRACE(seed);
    Chain chain(seed);
    Rng rng(seed + 9000);
    const double gap = rng.uniform(0.01, 1.0);
    const Index k = rng.integer(0, static_cast<int>(chain.qp.points) - 1);
    const Vector3d normal = rng.direction();
    const double at = normal.dot(chain.qp.first);
    const HalfSpaces below = halfSpace(normal, at - 0.5 * gap);
    const HalfSpaces above = halfSpace(-normal, -at - 0.5 * gap);
    chain.qp.sets[k] = {&below, &above};
    const PathQpSolution found = solve(chain.qp);
    EXPECT_EQ(found.report.termination, Termination::Infeasible) << found.report.message;
    // Nothing can do better than half the gap.
    EXPECT_NEAR(found.report.primal_residual, 0.5 * gap, 1e-3);
    EXPECT_NEAR(violation(chain.qp.sets, found.points), found.report.primal_residual, 1e-12);
    EXPECT_TRUE(found.points.allFinite());
  }
}

TEST(PathQp, WithoutSetsTheGradientVanishes)
{
  for (const Index points : {2, 3, 4, 5, 50})
  {
    SCOPED_TRACE(points);
    PathQp qp;
    qp.first = Vector3d(1.0, 2.0, 3.0);
    qp.last = Vector3d(4.0, 0.0, 3.5);
    qp.points = points;
    qp.margin = 0.3;
    const PathQpSolution found = solve(qp);
    ASSERT_TRUE(found.report.converged()) << found.report.message;
    EXPECT_LE(gradientOf(qp, found.points).cwiseAbs().maxCoeff(), 1e-5);
    // Not the degenerate answer of the printed Eq. (2), where the points collapse to one end.
    const Vector3d step = found.points.col(1) - found.points.col(0);
    EXPECT_GT(step.norm(), 0.5 * (qp.last - qp.first).norm() / static_cast<double>(points));
  }
}

TEST(PathQp, KeepsTheMarginWhereTheGapPermits)
{
  PathQp qp;
  qp.first = Vector3d(0.0, 0.0, 0.0);
  qp.last = Vector3d(6.0, 0.0, 0.0);
  qp.points = 13;
  qp.margin = 0.8;
  qp.w_slack = 1000.0;
  for (const double width : {4.0, 1.0})  // twice the margin fits; it does not
  {
    SCOPED_TRACE(width);
    // The wanted line runs 0.1 m beside one wall, y >= -0.1.
    HalfSpaces corridor;
    corridor.A.resize(2, 3);
    corridor.A << 0, -1, 0, 0, 1, 0;
    corridor.b = Eigen::Vector2d(0.1, width - 0.1);
    qp.sets.assign(13, {});
    for (Index k = 3; k <= 9; ++k) qp.sets[k] = {&corridor};
    const PathQpSolution found = solve(qp);
    ASSERT_TRUE(found.report.converged()) << found.report.message;
    const Eigen::ArrayXd y = found.points.block(1, 3, 1, 7).transpose().array() + 0.1;
    const double clearance = std::min(y.minCoeff(), (width - y).minCoeff());
    EXPECT_NEAR(clearance, std::min(0.8, 0.5 * width), 0.03);
  }
}

TEST(PathQp, FarAwayPlacesLoseNoDigits)
{
  for (std::uint64_t seed = 1; seed <= 50; ++seed)
  {
    SCOPED_TRACE(seed);
    Chain chain(seed);
    const PathQpSolution here = solve(chain.qp);
    const Vector3d shift(1e5, -2e5, 300.0);
    for (HalfSpaces& set : chain.polyhedra) set.b += set.A * shift;
    chain.qp.first += shift;
    chain.qp.last += shift;
    const PathQpSolution there = solve(chain.qp);
    ASSERT_TRUE(there.report.converged()) << there.report.message;
    EXPECT_LE((there.points.colwise() - shift - here.points).cwiseAbs().maxCoeff(), 1e-5);
  }
}

TEST(PathQp, MisuseIsReported)
{
  PathQp qp;
  qp.first = qp.last = Vector3d::Zero();
  qp.points = 1;
  EXPECT_EQ(solve(qp).report.termination, Termination::NumericalFailure);
  qp.points = 3;
  EXPECT_TRUE(solve(qp).report.converged());  // equal ends: all points in one place
  qp.sets.resize(2);
  EXPECT_EQ(solve(qp).report.termination, Termination::NumericalFailure);
  qp.sets.assign(3, {nullptr});
  EXPECT_EQ(solve(qp).report.termination, Termination::NumericalFailure);
  qp.sets.clear();
  qp.last.x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(solve(qp).report.termination, Termination::NumericalFailure);
}

}  // namespace
}  // namespace slalom::optim
