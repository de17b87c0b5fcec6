// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "PathChains.h"
#include "slalom/optim/Ipopt.h"

/// The programs over a chain of points written for an independent solver.
namespace slalom::optim::test
{
using Eigen::Ref;

/// One half-space of one point.
struct PointRow
{
  int point;
  Vector3d normal;
  double b;
};

inline std::vector<PointRow> rowsOf(const PathSets& sets)
{
  std::vector<PointRow> rows;
  for (std::size_t k = 0; k < sets.size(); ++k)
    for (const HalfSpaces* set : sets[k])
      for (Index i = 0; i < set->rows(); ++i)
        rows.push_back({static_cast<int>(k), set->A.row(i).transpose(), set->b[i]});
  return rows;
}

/// PathQp in Ipopt's words: x = [p, xi], every row a constraint.
class QuadraticProgram : public NonlinearProgram
{
 public:
  explicit QuadraticProgram(const PathQp& q) : q_(q), rows_(rowsOf(q.sets))
  {
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
  const PathQp& q_;
  std::vector<PointRow> rows_;
  std::vector<std::pair<std::vector<std::pair<int, double>>, double>> squares_;
  Eigen::MatrixXd H_;
};

/// Rows A p - b <= x_t for a chain of points; what is left to say is the cost and how many
/// variables stand behind the points.
class RowsProgram : public NonlinearProgram
{
 public:
  RowsProgram(Index points, const PathSets& sets, int extra)
      : points_(points), rows_(rowsOf(sets)), extra_(extra)
  {
  }
  int variables() const override { return static_cast<int>(3 * points_) + extra_; }
  int constraints() const override { return static_cast<int>(rows_.size()); }
  void bounds(Ref<VectorXd> xl, Ref<VectorXd> xu, Ref<VectorXd> gl, Ref<VectorXd> gu) const override
  {
    xl.setConstant(-1e3);
    xu.setConstant(1e3);
    gl.setConstant(-2e19);
    for (int i = 0; i < constraints(); ++i) gu[i] = rows_[static_cast<std::size_t>(i)].b;
  }
  std::vector<Entry> jacobianStructure() const override
  {
    std::vector<Entry> entries;
    for (int i = 0; i < constraints(); ++i)
    {
      for (int a = 0; a < 3; ++a)
        entries.push_back({i, 3 * rows_[static_cast<std::size_t>(i)].point + a});
      if (extra_ > 0) entries.push_back({i, static_cast<int>(3 * points_)});
    }
    return entries;
  }
  void constraint(const Ref<const VectorXd>& x, Ref<VectorXd> g) const override
  {
    for (int i = 0; i < constraints(); ++i)
    {
      const PointRow& row = rows_[static_cast<std::size_t>(i)];
      g[i] = row.normal.dot(x.segment<3>(3 * row.point)) - (extra_ > 0 ? x[3 * points_] : 0.0);
    }
  }
  void jacobian(const Ref<const VectorXd>&, Ref<VectorXd> v) const override
  {
    const Index width = extra_ > 0 ? 4 : 3;
    for (int i = 0; i < constraints(); ++i)
    {
      v.segment<3>(width * i) = rows_[static_cast<std::size_t>(i)].normal;
      if (extra_ > 0) v[width * i + 3] = -1.0;
    }
  }

 protected:
  Index points_;
  std::vector<PointRow> rows_;
  int extra_;
};

/// Is there a point for every set? min t s.t. A p - b <= t, t >= -1.
class PhaseOne final : public RowsProgram
{
 public:
  PhaseOne(Index points, const PathSets& sets) : RowsProgram(points, sets, 1) {}
  void bounds(Ref<VectorXd> xl, Ref<VectorXd> xu, Ref<VectorXd> gl, Ref<VectorXd> gu) const override
  {
    RowsProgram::bounds(xl, xu, gl, gu);
    xl[3 * points_] = -1.0;
  }
  std::vector<Entry> hessianStructure() const override
  {
    std::vector<Entry> entries;
    for (int i = 0; i < variables(); ++i) entries.push_back({i, i});
    return entries;
  }
  double cost(const Ref<const VectorXd>& x) const override { return x[3 * points_]; }
  void gradient(const Ref<const VectorXd>&, Ref<VectorXd> g) const override
  {
    g.setZero();
    g[3 * points_] = 1.0;
  }
  void hessian(const Ref<const VectorXd>&, double, const Ref<const VectorXd>&,
               Ref<VectorXd> v) const override
  {
    v.setZero();
  }
};

/** PathSocp with every |v| rounded up to r(v) = sqrt(|v|^2 + eps^2).
 *
 *  At its optimum the forces w v / r(v) are multipliers of the true problem, too, and prove that
 * nobody costs less than the rounded cost minus lost(): the sum of w eps^2 / r(v). */
class NormProgram final : public RowsProgram
{
 public:
  NormProgram(const PathSocp& q, double eps) : RowsProgram(q.points, q.sets, 0), q_(q), eps_(eps) {}

  [[nodiscard]] double lost(const Ref<const VectorXd>& x) const
  {
    double sum = 0.0;
    forEachTerm(
        x, [&](double w, const Vector3d& v, Index, Index) { sum += w * eps_ * eps_ / rounded(v); });
    return sum;
  }
  std::vector<Entry> hessianStructure() const override
  {
    std::vector<Entry> entries;
    for (int k = 0; k < q_.points; ++k)
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j <= i; ++j) entries.push_back({3 * k + i, 3 * k + j});
    for (int k = 1; k < q_.points; ++k)
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) entries.push_back({3 * k + i, 3 * k - 3 + j});
    return entries;
  }
  double cost(const Ref<const VectorXd>& x) const override
  {
    double sum = 0.0;
    forEachTerm(x, [&](double w, const Vector3d& v, Index, Index) { sum += w * rounded(v); });
    return sum;
  }
  void gradient(const Ref<const VectorXd>& x, Ref<VectorXd> g) const override
  {
    g.setZero();
    forEachTerm(x,
                [&](double w, const Vector3d& v, Index from, Index to)
                {
                  const Vector3d pull = w * v / rounded(v);
                  if (from >= 0) g.segment<3>(3 * from) -= pull;
                  if (to < q_.points) g.segment<3>(3 * to) += pull;
                });
  }
  void hessian(const Ref<const VectorXd>& x, double sigma, const Ref<const VectorXd>&,
               Ref<VectorXd> values) const override
  {
    values.setZero();
    forEachTerm(x,
                [&](double w, const Vector3d& v, Index from, Index to)
                {
                  const double r = rounded(v);
                  const Eigen::Matrix3d block =
                      sigma * w / r * (Eigen::Matrix3d::Identity() - v * v.transpose() / (r * r));
                  for (const Index k : {from, to})
                    if (k >= 0 && k < q_.points)
                      for (int i = 0, at = 0; i < 3; ++i)
                        for (int j = 0; j <= i; ++j) values[6 * k + at++] += block(i, j);
                  if (from >= 0 && to < q_.points)
                    for (int i = 0; i < 3; ++i)
                      for (int j = 0; j < 3; ++j)
                        values[6 * q_.points + 9 * from + 3 * i + j] -= block(i, j);
                });
  }

 private:
  [[nodiscard]] double rounded(const Vector3d& v) const
  {
    return std::sqrt(v.squaredNorm() + eps_ * eps_);
  }
  /// term(weight, v, point it leaves or -1, point it reaches or `points`)
  template <class Term>
  void forEachTerm(const Ref<const VectorXd>& x, Term&& term) const
  {
    const Index n = q_.points;
    const auto at = [&](Index k) { return x.segment<3>(3 * k); };
    term(q_.w_start, Vector3d(at(0) - q_.first), -1, 0);
    for (Index k = 1; k < n; ++k) term(q_.w_length, Vector3d(at(k) - at(k - 1)), k - 1, k);
    term(q_.w_end, Vector3d(q_.last - at(n - 1)), n - 1, n);
  }

  const PathSocp& q_;
  double eps_;
};

/// The dead-zone problem [Paper Eq. (5)] as one program, its norms squared (the same minimiser,
/// point by point).
class DeadZoneProgram final : public RowsProgram
{
 public:
  DeadZoneProgram(const Matrix3Xd& wanted, const PathSets& sets)
      : RowsProgram(wanted.cols(), sets, 0), wanted_(wanted.reshaped())
  {
  }
  std::vector<Entry> hessianStructure() const override
  {
    std::vector<Entry> entries;
    for (int i = 0; i < variables(); ++i) entries.push_back({i, i});
    return entries;
  }
  double cost(const Ref<const VectorXd>& x) const override { return (x - wanted_).squaredNorm(); }
  void gradient(const Ref<const VectorXd>& x, Ref<VectorXd> g) const override
  {
    g = 2.0 * (x - wanted_);
  }
  void hessian(const Ref<const VectorXd>&, double sigma, const Ref<const VectorXd>&,
               Ref<VectorXd> values) const override
  {
    values.setConstant(2.0 * sigma);
  }

 private:
  VectorXd wanted_;
};

}  // namespace slalom::optim::test
