// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <Eigen/QR>
#include <algorithm>
#include <deque>
#include <limits>

#include "NlpCheck.h"
#include "slalom/core/Rng.h"
#include "slalom/optim/Ipopt.h"
#include "slalom/optim/PathQp.h"

namespace
{
using Eigen::Index;
using Eigen::Matrix3Xd;
using Eigen::Ref;
using Eigen::Vector3d;
using Eigen::VectorXd;
using slalom::core::Deadline;
using slalom::core::HalfSpaces;
using slalom::core::Rng;
using slalom::core::Termination;
using namespace slalom::optim;

/// Random half-spaces that all hold `inside` with at least `room` to spare.
HalfSpaces around(Rng& rng, const Vector3d& inside, int rows, double room)
{
  HalfSpaces set;
  set.A.resize(rows, 3);
  set.b.resize(rows);
  for (int i = 0; i < rows; ++i)
  {
    const Vector3d normal = rng.direction();
    set.A.row(i) = normal.transpose();
    set.b[i] = normal.dot(inside) + rng.uniform(room, room + 0.6);
  }
  return set;
}

/// A winding guide with polyhedra shared by neighbouring points, as the global planner makes them.
struct Chain
{
  explicit Chain(std::uint64_t seed)
  {
    Rng rng(seed);
    qp.points = rng.integer(2, 30);
    qp.margin = rng.integer(0, 2) == 0 ? 0.0 : rng.uniform(0.05, 0.8);
    qp.w_bend = rng.integer(0, 3) == 0 ? 0.0 : rng.uniform(0.1, 3.0);
    qp.w_length = rng.uniform(0.2, 2.0);
    qp.w_slack = rng.uniform(1.0, 30.0);
    qp.sets.resize(qp.points);
    Vector3d guide = rng.uniform3(-50.0, 50.0), heading = rng.direction();
    qp.first = guide;
    for (Index k = 0; k < qp.points; ++k)
    {
      if (k == 0 || rng.integer(0, 3) == 0)
        polyhedra.push_back(around(rng, guide, rng.integer(3, 12), 0.05));
      // Sharing is only promised as far as the set holds the guide.
      if (!polyhedra.back().contains(guide, -0.02))
        polyhedra.push_back(around(rng, guide, rng.integer(3, 12), 0.05));
      qp.sets[k].push_back(&polyhedra.back());
      if (rng.integer(0, 4) == 0)
      {
        polyhedra.push_back(around(rng, guide, 4, 0.05));
        qp.sets[k].push_back(&polyhedra.back());
      }
      heading = (heading + 0.7 * rng.direction()).normalized();
      if (k + 1 < qp.points) guide += 0.3 * heading;
    }
    qp.last = guide;
  }
  PathQp qp;
  std::deque<HalfSpaces> polyhedra;
};

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

/// Distance of v from the cone of the columns of N: by Caratheodory three columns suffice.
double distanceFromCone(const Vector3d& v, const Matrix3Xd& N)
{
  double best = v.norm();
  const Index m = N.cols();
  for (Index a = 0; a < m; ++a)
    for (Index b = a; b < m; ++b)
      for (Index c = b; c < m; ++c)
      {
        std::vector<Index> pick{a};
        if (b > a) pick.push_back(b);
        if (c > b) pick.push_back(c);
        const Eigen::MatrixXd basis = N(Eigen::all, pick);
        const VectorXd weight = basis.colPivHouseholderQr().solve(v);
        if ((weight.array() >= 0.0).all()) best = std::min(best, (basis * weight - v).norm());
      }
  return best;
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
    worst = std::max(worst, distanceFromCone(-gradient.col(k), active));
  }
  return worst;
}

double violation(const PathQp& q, const Matrix3Xd& p)
{
  double worst = 0.0;
  for (Index k = 0; k < p.cols(); ++k)
    for (const HalfSpaces* set : q.sets[k]) worst = std::max(worst, set->violation(p.col(k)));
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
    EXPECT_LE(violation(chain.qp, found.points), 1e-7);
    EXPECT_LE(found.report.primal_residual, 1e-7);
    EXPECT_LE(stationarityGap(chain.qp, found.points), 1e-3);
    EXPECT_NEAR(found.report.cost, objective(chain.qp, found.points),
                1e-6 * (1.0 + found.report.cost));
    with_active_rows += violation(chain.qp, found.points) > -1e-6;
  }
  EXPECT_GT(with_active_rows, 500);  // the generator must not make it easy
}

/// The same problem in Ipopt's words: x = [p, xi], every row a constraint.
class PathProgram : public NonlinearProgram
{
 public:
  explicit PathProgram(const PathQp& q) : q_(q)
  {
    for (std::size_t k = 0; k < q.sets.size(); ++k)
      for (const HalfSpaces* set : q.sets[k])
        for (Index i = 0; i < set->rows(); ++i)
          rows_.push_back({static_cast<int>(k), set->A.row(i).transpose(), set->b[i]});
    const auto square = [&](std::vector<std::pair<int, double>> terms, double weight) {
      squares_.push_back({std::move(terms), weight});
    };
    const int n = static_cast<int>(q.points);
    for (int k = 0; k + 1 < n; ++k) square({{k, -1.0}, {k + 1, 1.0}}, q.w_length);
    for (int k = 1; k + 1 < n; ++k) square({{k - 1, 1.0}, {k, -2.0}, {k + 1, 1.0}}, q.w_bend);
    H_ = Eigen::MatrixXd::Zero(n, n);
    H_(0, 0) += 2.0 * q.w_start;
    H_(n - 1, n - 1) += 2.0 * q.w_end;
    for (const auto& [terms, weight] : squares_)
      for (const auto& [i, a] : terms)
        for (const auto& [j, b] : terms) H_(i, j) += 2.0 * weight * a * b;
  }
  int variables() const override { return static_cast<int>(3 * q_.points) + constraints(); }
  int constraints() const override { return static_cast<int>(rows_.size()); }
  void bounds(Ref<VectorXd> xl, Ref<VectorXd> xu, Ref<VectorXd> gl, Ref<VectorXd> gu) const override
  {
    xl.setConstant(-2e19);
    xu.setConstant(2e19);
    xl.tail(constraints()).setZero();
    xu.tail(constraints()).setConstant(q_.margin);
    gl.setConstant(-2e19);
    for (int i = 0; i < constraints(); ++i) gu[i] = rows_[i].b - q_.margin;
  }
  std::vector<Entry> jacobianStructure() const override
  {
    std::vector<Entry> entries;
    for (int i = 0; i < constraints(); ++i)
    {
      for (int a = 0; a < 3; ++a) entries.push_back({i, 3 * rows_[i].point + a});
      entries.push_back({i, static_cast<int>(3 * q_.points) + i});
    }
    return entries;
  }
  std::vector<Entry> hessianStructure() const override
  {
    std::vector<Entry> entries;
    for (int i = 0; i < q_.points; ++i)
      for (int j = std::max(0, i - 2); j <= i; ++j)
        for (int a = 0; a < 3; ++a) entries.push_back({3 * i + a, 3 * j + a});
    for (int i = 0; i < constraints(); ++i)
      entries.push_back({static_cast<int>(3 * q_.points) + i, static_cast<int>(3 * q_.points) + i});
    return entries;
  }
  double cost(const Ref<const VectorXd>& x) const override
  {
    const Matrix3Xd p = x.head(3 * q_.points).reshaped(3, q_.points);
    return q_.w_start * (p.col(0) - q_.first).squaredNorm() +
           q_.w_end * (p.col(q_.points - 1) - q_.last).squaredNorm() + squares(p) +
           q_.w_slack * x.tail(constraints()).squaredNorm();
  }
  void gradient(const Ref<const VectorXd>& x, Ref<VectorXd> g) const override
  {
    const Matrix3Xd p = x.head(3 * q_.points).reshaped(3, q_.points);
    Matrix3Xd d = p * H_;
    d.col(0) -= 2.0 * q_.w_start * q_.first;
    d.col(q_.points - 1) -= 2.0 * q_.w_end * q_.last;
    g.head(3 * q_.points) = d.reshaped();
    g.tail(constraints()) = 2.0 * q_.w_slack * x.tail(constraints());
  }
  void constraint(const Ref<const VectorXd>& x, Ref<VectorXd> g) const override
  {
    for (int i = 0; i < constraints(); ++i)
      g[i] = rows_[i].normal.dot(x.segment<3>(3 * rows_[i].point)) - x[3 * q_.points + i];
  }
  void jacobian(const Ref<const VectorXd>&, Ref<VectorXd> v) const override
  {
    for (int i = 0; i < constraints(); ++i)
    {
      v.segment<3>(4 * i) = rows_[i].normal;
      v[4 * i + 3] = -1.0;
    }
  }
  void hessian(const Ref<const VectorXd>&, double sigma, const Ref<const VectorXd>&,
               Ref<VectorXd> v) const override
  {
    Index at = 0;
    for (int i = 0; i < q_.points; ++i)
      for (int j = std::max(0, i - 2); j <= i; ++j)
        for (int a = 0; a < 3; ++a) v[at++] = sigma * H_(i, j);
    v.tail(constraints()).setConstant(2.0 * sigma * q_.w_slack);
  }

 private:
  double squares(const Matrix3Xd& p) const
  {
    double sum = 0.0;
    for (const auto& [terms, weight] : squares_)
    {
      Vector3d v = Vector3d::Zero();
      for (const auto& [k, a] : terms) v += a * p.col(k);
      sum += weight * v.squaredNorm();
    }
    return sum;
  }
  struct Row
  {
    int point;
    Vector3d normal;
    double b;
  };
  const PathQp& q_;
  std::vector<Row> rows_;
  std::vector<std::pair<std::vector<std::pair<int, double>>, double>> squares_;
  Eigen::MatrixXd H_;
};

TEST(PathQp, CostEqualsAnIndependentSolution)
{
  for (std::uint64_t seed = 5001; seed <= 5200; ++seed)
  {
    SCOPED_TRACE(seed);
    Chain chain(seed);
    chain.qp.margin = std::max(chain.qp.margin, 0.05);  // a slack fixed at zero has no interior
    const PathProgram program(chain.qp);
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

HalfSpaces halfSpace(const Vector3d& normal, double b)
{
  HalfSpaces set;
  set.A = normal.transpose();
  set.b = VectorXd::Constant(1, b);
  return set;
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
    EXPECT_NEAR(violation(chain.qp, found.points), found.report.primal_residual, 1e-12);
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
