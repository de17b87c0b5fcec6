// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <limits>

#include "ChainProblems.h"
#include "NlpCheck.h"
#include "PathChains.h"
#include "PathPrograms.h"
#include "SharedData.h"

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

/// A chain whose wanted ends may lie outside its sets and whose weights may favour either term.
PathSocp vary(const Chain& chain, std::uint64_t seed)
{
  Rng rng(seed + 77);
  PathSocp q = chain.socp();
  if (rng.integer(0, 1) == 0) q.first += rng.uniform(0.0, 2.0) * rng.direction();
  if (rng.integer(0, 1) == 0) q.last += rng.uniform(0.0, 2.0) * rng.direction();
  if (rng.integer(0, 2) == 0)
  {
    q.w_start = rng.uniform(0.2, 2.0);
    q.w_end = rng.uniform(0.2, 2.0);
    q.w_length = rng.uniform(0.2, 2.0);
  }
  return q;
}

struct Term
{
  double weight;
  Vector3d v;
};

/// The terms of the cost in the order of the tensions.
std::vector<Term> termsOf(const PathSocp& q, const Matrix3Xd& p)
{
  std::vector<Term> terms = {{q.w_start, p.col(0) - q.first}};
  for (Index k = 1; k < p.cols(); ++k) terms.push_back({q.w_length, p.col(k) - p.col(k - 1)});
  terms.push_back({q.w_end, q.last - p.rightCols(1)});
  return terms;
}

double objective(const PathSocp& q, const Matrix3Xd& p)
{
  double sum = 0.0;
  for (const Term& term : termsOf(q, p)) sum += term.weight * term.v.norm();
  return sum;
}

/// The optimality conditions of a convex program, told from the answer alone: forces within their
/// weights and along their terms, and at every point carried by planes that it touches.
void expectOptimal(const PathSocp& q, const PathSocpSolution& found, double tolerance)
{
  ASSERT_EQ(found.points.cols(), q.points);
  ASSERT_EQ(found.tensions.cols(), q.points + 1);
  EXPECT_LE(violation(q.sets, found.points), 1e-7);
  EXPECT_NEAR(found.report.cost, objective(q, found.points), 1e-9 * (1.0 + found.report.cost));
  EXPECT_LE(found.report.cost - found.lower_bound, tolerance);
  EXPECT_GE(found.report.cost - found.lower_bound, -1e-7);
  const std::vector<Term> terms = termsOf(q, found.points);
  for (Index e = 0; e <= q.points; ++e)
  {
    const auto& [weight, v] = terms[std::size_t(e)];
    const Vector3d y = found.tensions.col(e);
    EXPECT_LE(y.norm(), weight * (1.0 + 1e-9));
    EXPECT_LE(weight * v.norm() - y.dot(v), tolerance);
  }
  for (Index k = 0; k < q.points; ++k)
  {
    Matrix3Xd touched(3, 0);
    if (!q.sets.empty())
      for (const HalfSpaces* set : q.sets[std::size_t(k)])
        for (Index i = 0; i < set->rows(); ++i)
          if (set->A.row(i).dot(found.points.col(k)) > set->b[i] - 1e-4)
          {
            touched.conservativeResize(3, touched.cols() + 1);
            touched.rightCols(1) = set->A.row(i).transpose();
          }
    const Vector3d carried = found.tensions.col(k + 1) - found.tensions.col(k);
    EXPECT_LE(test::distanceFromCone(carried, touched), 1e-3) << "point " << k;
  }
}

TEST(PathSocp, OptimalityConditionsHoldOnThousandsOfChains)
{
  int with_active_rows = 0, interior = 0;
  for (std::uint64_t seed = 1; seed <= 3000; ++seed)
  {
    SCOPED_TRACE(seed);
    const Chain chain(seed);
    const PathSocp q = vary(chain, seed);
    const PathSocpSolution found = solve(q, {.max_iterations = 60, .tolerance = 1e-8});
    ASSERT_TRUE(found.report.converged())
        << found.report.message << " after " << found.report.iterations;
    expectOptimal(q, found, 3e-7);
    interior += found.report.iterations > 0;
    with_active_rows += violation(q.sets, found.points) > -1e-6;
  }
  EXPECT_GT(with_active_rows, 1500);  // the generator must not make it easy
  EXPECT_GT(interior, 1500);
}

/// Brackets the smallest cost by Ipopt's solution of the rounded problem.
/// @return false when the bracket is wide or Ipopt failed: then the comparison says little
bool expectSameCost(IpoptSolver& ipopt, const PathSocp& q, const VectorXd& start)
{
  const test::NormProgram program(q, 1e-3);
  const NlpSolution oracle = ipopt.solve(program, {start, {}, {}, {}}, Deadline::none());
  const PathSocpSolution found = solve(q);
  EXPECT_TRUE(found.report.converged()) << found.report.message;
  if (!oracle.report.converged() || oracle.report.primal_residual > 1e-6) return false;
  const double width = program.lost(oracle.point.x);
  EXPECT_LE(found.report.cost, objective(q, oracle.point.x.reshaped(3, q.points)) + 1e-5);
  EXPECT_GE(found.report.cost, oracle.report.cost - width - 1e-5);
  return width < 5e-3;
}

IpoptConfig oracleConfig()
{
  return {.tolerance = 1e-7, .max_iterations = 400, .initial_barrier = 0.1};
}

TEST(PathSocp, CostEqualsAnIndependentSolution)
{
  IpoptSolver ipopt(oracleConfig());
  int decisive = 0;
  for (std::uint64_t seed = 5001; seed <= 5300; ++seed)
  {
    SCOPED_TRACE(seed);
    const Chain chain(seed, 12);
    const PathSocp q = vary(chain, seed);
    VectorXd start(3 * q.points);
    for (Index k = 0; k < q.points; ++k)
      start.segment<3>(3 * k) = q.first + (q.last - q.first) * (double(k) / double(q.points - 1));
    if (seed < 5010)
    {
      const test::NormProgram blunt(q, 0.1);
      slalom::test::expectExactDerivatives(blunt, start, 1.0, VectorXd::Ones(blunt.constraints()),
                                           1e-5);
    }
    decisive += expectSameCost(ipopt, q, start);
  }
  EXPECT_GE(decisive, 285);
}

/// Sets of which a point's two may or may not meet.
Chain doubtful(std::uint64_t seed)
{
  Chain chain(seed, 12);
  Rng rng(seed + 31);
  const auto k = static_cast<std::size_t>(rng.integer(0, int(chain.qp.points) - 1));
  const Vector3d centre = chain.qp.first + rng.uniform(0.0, 0.9) * rng.direction();
  Vector3d other = centre + rng.uniform(0.3, 1.2) * rng.direction();
  chain.polyhedra.push_back(test::around(rng, centre, 10, 0.05));
  chain.polyhedra.push_back(test::around(rng, other, 10, 0.05));
  chain.qp.sets[k] = {&chain.polyhedra[chain.polyhedra.size() - 2], &chain.polyhedra.back()};
  return chain;
}

TEST(PathSocp, BothFormulationsAreInfeasibleExactlyWhenPhaseOneSaysSo)
{
  IpoptSolver ipopt({.tolerance = 1e-8, .max_iterations = 300, .initial_barrier = 0.1});
  int feasible = 0, infeasible = 0, unsure = 0;
  for (std::uint64_t seed = 1; seed <= 300; ++seed)
  {
    SCOPED_TRACE(seed);
    const Chain chain = doubtful(seed);
    const test::PhaseOne program(chain.qp.points, chain.qp.sets);
    NlpPoint start{VectorXd::Zero(program.variables()), {}, {}, {}};
    for (Index k = 0; k < chain.qp.points; ++k) start.x.segment<3>(3 * k) = chain.qp.first;
    const NlpSolution oracle = ipopt.solve(program, start, Deadline::none());
    const double least = oracle.report.cost;
    if (!oracle.report.converged() || (least > -1e-5 && least < 2e-4))
    {
      ++unsure;
      continue;
    }
    ++(least > 0.0 ? infeasible : feasible);
    const Termination expected = least > 0.0 ? Termination::Infeasible : Termination::Converged;
    const PathSocpSolution norms = solve(chain.socp());
    EXPECT_EQ(norms.report.termination, expected) << least << " " << norms.report.message;
    const PathQpSolution squares = solve(chain.qp);
    EXPECT_EQ(squares.report.termination, expected) << least << " " << squares.report.message;
    EXPECT_GE(norms.report.primal_residual, least - 1e-6);  // nobody violates less than the least
  }
  EXPECT_GT(feasible, 80);
  EXPECT_GT(infeasible, 80);
  EXPECT_LT(unsure, 8);
}

TEST(PathSocp, ContradictionsAreReportedWithTheLeastViolatingPath)
{
  for (std::uint64_t seed = 1; seed <= 200; ++seed)
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
    chain.qp.sets[std::size_t(k)] = {&below, &above};
    const PathSocpSolution found = solve(chain.socp());
    EXPECT_EQ(found.report.termination, Termination::Infeasible) << found.report.message;
    EXPECT_NEAR(found.report.primal_residual, 0.5 * gap, 1e-3);
    EXPECT_NEAR(violation(chain.qp.sets, found.points), found.report.primal_residual, 1e-12);
  }
}

/// As printed, with its sum from k = 1, Eq. (2) is solved by p_0 = first, all others = last.
TEST(PathSocp, DoesNotCollapseToOneEnd)
{
  for (std::uint64_t seed = 1; seed <= 300; ++seed)
  {
    SCOPED_TRACE(seed);
    const Chain chain(seed);
    if (chain.qp.points < 8) continue;
    const PathSocp q = chain.socp();
    const PathSocpSolution found = solve(q);
    ASSERT_TRUE(found.report.converged());
    // The ends stay where they are wanted, and no single step makes the whole way.
    EXPECT_LE((found.points.col(0) - q.first).norm(), 1e-5);
    EXPECT_LE((found.points.rightCols(1) - q.last).norm(), 1e-5);
    const Index n = q.points - 1;
    const double longest =
        (found.points.rightCols(n) - found.points.leftCols(n)).colwise().norm().maxCoeff();
    const double whole =
        (found.points.rightCols(n) - found.points.leftCols(n)).colwise().norm().sum();
    EXPECT_LT(longest, 0.9 * whole);
  }
}

TEST(PathSocp, OnePolyhedronGivesTheEvenChord)
{
  int inside = 0, outside = 0;
  for (std::uint64_t seed = 1; seed <= 500; ++seed)
  {
    SCOPED_TRACE(seed);
    Rng rng(seed);
    const Vector3d centre = rng.uniform3(-5.0, 5.0);
    const HalfSpaces set = test::around(rng, centre, 12, 0.2);
    PathSocp q;
    q.first = centre + rng.uniform(0.0, 0.6) * rng.direction();
    q.last = centre + rng.uniform(0.0, 0.6) * rng.direction();
    q.points = rng.integer(2, 20);
    q.sets.assign(std::size_t(q.points), {&set});
    const PathSocpSolution found = solve(q);
    ASSERT_TRUE(found.report.converged()) << found.report.message;
    expectOptimal(q, found, 1e-6);
    const bool holds_both = set.contains(q.first) && set.contains(q.last);
    ++(holds_both ? inside : outside);
    const Vector3d a = holds_both ? q.first : found.points.col(0).eval();
    const Vector3d b = holds_both ? q.last : found.points.col(q.points - 1).eval();
    for (Index k = 0; k < q.points; ++k)
      EXPECT_LE((found.points.col(k) - a - (b - a) * (double(k) / double(q.points - 1))).norm(),
                1e-9);
    // The shortcut agrees with the long way: one copy of the set per point.
    std::deque<HalfSpaces> copies;
    for (auto& of_point : q.sets) of_point = {&copies.emplace_back(set)};
    EXPECT_NEAR(solve(q).report.cost, found.report.cost, 1e-6 * (1.0 + found.report.cost));
  }
  EXPECT_GT(inside, 100);
  EXPECT_GT(outside, 100);
}

TEST(PathSocp, AnLShapedCorridorIsBentAtItsOverlap)
{
  // Along x for 0 <= y <= 1, then along y for 4 <= x <= 5; the inner corner is (4, 1).
  HalfSpaces along_x, along_y;
  along_x.A.resize(3, 3);
  along_x.A << 0, -1, 0, 0, 1, 0, 1, 0, 0;
  along_x.b = Vector3d(0.0, 1.0, 5.0);
  along_y.A.resize(3, 3);
  along_y.A << -1, 0, 0, 1, 0, 0, 0, -1, 0;
  along_y.b = Vector3d(-4.0, 5.0, 0.0);
  PathSocp q;
  q.first = Vector3d(0.0, 0.5, 1.0);
  q.last = Vector3d(4.5, 5.0, 1.0);
  q.points = 21;
  for (Index k = 0; k < q.points; ++k)
  {
    q.sets.emplace_back();
    if (k <= 10) q.sets.back().push_back(&along_x);
    if (k >= 10) q.sets.back().push_back(&along_y);
  }
  const PathSocpSolution found = solve(q);
  ASSERT_TRUE(found.report.converged()) << found.report.message;
  expectOptimal(q, found, 1e-6);
  const Vector3d corner(4.0, 1.0, 1.0);
  EXPECT_NEAR(found.report.cost, 0.6 * ((corner - q.first).norm() + (q.last - corner).norm()),
              1e-6);
  EXPECT_LE((found.points.col(10) - corner).norm(), 1e-4);
}

TEST(PathSocp, ASetWithoutInteriorIsNoObstacle)
{
  // A guide through a gap that is exactly as wide as the vehicle: the planes of both sides meet.
  for (std::uint64_t seed = 1; seed <= 200; ++seed)
  {
    SCOPED_TRACE(seed);
    Rng rng(seed);
    const Vector3d normal = rng.direction(), a = rng.uniform3(-3.0, 3.0);
    const Vector3d b = a + normal.cross(rng.direction()) * 3.0;
    HalfSpaces slit;
    slit.A.resize(2, 3);
    slit.A << normal.transpose(), -normal.transpose();
    slit.b = Eigen::Vector2d(normal.dot(a), -normal.dot(a));
    PathSocp q;
    q.first = a + 0.3 * rng.direction();
    q.last = b + 0.3 * rng.direction();
    q.points = 11;
    q.sets.resize(11);
    for (std::size_t k = 2; k < 8; ++k) q.sets[k] = {&slit};
    const PathSocpSolution found = solve(q);
    ASSERT_TRUE(found.report.converged()) << found.report.message << found.report.primal_residual;
    EXPECT_LE(found.report.primal_residual, 1e-6);
    EXPECT_LE(found.report.cost - found.lower_bound, 1e-5);
  }
}

TEST(PathSocp, FarAwayPlacesLoseNoDigits)
{
  for (std::uint64_t seed = 1; seed <= 50; ++seed)
  {
    SCOPED_TRACE(seed);
    Chain chain(seed);
    const PathSocpSolution here = solve(chain.socp());
    const Vector3d shift(1e5, -2e5, 300.0);
    for (HalfSpaces& set : chain.polyhedra) set.b += set.A * shift;
    chain.qp.first += shift;
    chain.qp.last += shift;
    const PathSocpSolution there = solve(chain.socp());
    ASSERT_TRUE(there.report.converged()) << there.report.message;
    EXPECT_NEAR(there.report.cost, here.report.cost, 1e-6);
  }
}

TEST(PathSocp, MisuseIsReported)
{
  PathSocp q;
  q.first = q.last = Vector3d::Zero();
  q.points = 1;
  EXPECT_EQ(solve(q).report.termination, Termination::NumericalFailure);
  q.points = 3;
  EXPECT_TRUE(solve(q).report.converged());  // equal ends: all points in one place
  q.w_start = 0.0;
  EXPECT_EQ(solve(q).report.termination, Termination::NumericalFailure);
  q.w_start = 0.8;
  q.sets.resize(2);
  EXPECT_EQ(solve(q).report.termination, Termination::NumericalFailure);
  q.sets.assign(3, {nullptr});
  EXPECT_EQ(solve(q).report.termination, Termination::NumericalFailure);
  q.sets.clear();
  q.last.x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(solve(q).report.termination, Termination::NumericalFailure);
}

/// The measured instances: solved, proved by their own forces, and not beaten by Ipopt.
void solveFile(const char* name, std::size_t with_oracle)
{
  const auto file = slalom::test::sharedData(std::filesystem::path("problems") / name);
  if (!exists(file)) GTEST_SKIP() << "no evaluation data: " << file;
  IpoptSolver ipopt(oracleConfig());
  const auto problems = slalom::test::readChainProblems(file);
  ASSERT_EQ(problems.size(), 60u);
  for (std::size_t i = 0; i < problems.size(); ++i)
  {
    SCOPED_TRACE(problems[i].id);
    PathSocp q;
    q.first = problems[i].points.col(0);
    q.last = problems[i].points.rightCols(1);
    q.points = problems[i].points.cols();
    q.sets = problems[i].perPoint();
    q.w_start = problems[i].l1, q.w_end = problems[i].l2, q.w_length = problems[i].l3;
    const PathSocpSolution found = solve(q);
    ASSERT_TRUE(found.report.converged()) << found.report.message;
    expectOptimal(q, found, 1e-6);
    const bool asked = i < with_oracle;
    EXPECT_TRUE(!asked || expectSameCost(ipopt, q, problems[i].points.reshaped()));
  }
}

TEST(PathSocp, SolvesTheMeasuredInstancesOfOnePolyhedron)
{
  solveFile("socp_push_k0_n15_m20.txt", 20);
}
TEST(PathSocp, SolvesTheMeasuredInstancesOfAChain)
{
  solveFile("socp_push_k1_n15_m20.txt", 20);
}
TEST(PathSocp, SolvesTheMeasuredLargerInstances)
{
  solveFile("socp_push_k0_n30_m40.txt", 3);
}

}  // namespace
}  // namespace slalom::optim
