// SPDX-License-Identifier: BSD-3-Clause
#include <array>
#include <cmath>
#include <limits>

#include "slalom/geometry/ConvexDecomposition.h"

namespace slalom::geometry
{
namespace
{
constexpr double kFeasible = 1e-10;     ///< [m] a plane violated by less is kept
constexpr double kIndependent = 1e-14;  ///< squared sine below which a normal adds no direction

/** Active planes (at most three) of the dual method, with their orthonormal basis: column k of the
 * normals is basis.leftCols(k + 1) times column k of `triangle`. */
class ActivePlanes
{
 public:
  ActivePlanes(const Eigen::Vector3d& x, const core::HalfSpaces& set) : x_(x), set_(set) {}

  int count = 0;
  std::array<Eigen::Index, 3> rows{};
  Eigen::Vector3d multiplier = Eigen::Vector3d::Zero();

  /// What is left of a normal when the active ones are taken out, and its share of each of them.
  Eigen::Vector3d residual(const Eigen::Vector3d& normal, Eigen::Vector3d& share) const
  {
    Eigen::Vector3d rest = normal, along = Eigen::Vector3d::Zero();
    for (int pass = 0; pass < 2; ++pass)  // the second pass removes the rounding of the first
      for (int k = 0; k < count; ++k)
      {
        const double part = basis_.col(k).dot(rest);
        along[k] += part;
        rest -= part * basis_.col(k);
      }
    share = along;
    for (int k = count - 1; k >= 0; --k)
    {
      for (int j = k + 1; j < count; ++j) share[k] -= triangle_(k, j) * share[j];
      share[k] /= triangle_(k, k);
    }
    return rest;
  }

  void add(Eigen::Index row, double value)
  {
    rows[static_cast<std::size_t>(count)] = row;
    multiplier[count] = value;
    ++count;
    factorise();
  }
  void drop(int k)
  {
    for (int j = k; j + 1 < count; ++j)
    {
      rows[static_cast<std::size_t>(j)] = rows[static_cast<std::size_t>(j + 1)];
      multiplier[j] = multiplier[j + 1];
    }
    --count;
    factorise();
  }
  /// Nearest point to x on the intersection of the active planes; no drift from step to step.
  [[nodiscard]] Eigen::Vector3d pointOnPlanes() const
  {
    // p = x - Q y with R^T y = N^T x - b.
    Eigen::Vector3d p = x_, y = Eigen::Vector3d::Zero();
    for (int k = 0; k < count; ++k)
    {
      const Eigen::Index row = rows[static_cast<std::size_t>(k)];
      y[k] = set_.A.row(row).dot(x_) - set_.b[row];
      for (int j = 0; j < k; ++j) y[k] -= triangle_(j, k) * y[j];
      y[k] /= triangle_(k, k);
      p -= y[k] * basis_.col(k);
    }
    return p;
  }

 private:
  void factorise()
  {
    for (int k = 0; k < count; ++k)
    {
      Eigen::Vector3d rest = set_.A.row(rows[static_cast<std::size_t>(k)]).transpose();
      triangle_.col(k).setZero();
      for (int pass = 0; pass < 2; ++pass)
        for (int j = 0; j < k; ++j)
        {
          const double part = basis_.col(j).dot(rest);
          triangle_(j, k) += part;
          rest -= part * basis_.col(j);
        }
      triangle_(k, k) = rest.norm();
      basis_.col(k) = rest / triangle_(k, k);
    }
  }

  const Eigen::Vector3d& x_;
  const core::HalfSpaces& set_;
  Eigen::Matrix3d basis_ = Eigen::Matrix3d::Zero(), triangle_ = Eigen::Matrix3d::Zero();
};

enum class Outcome
{
  Added,
  Empty
};

/** Makes plane `row` active, starting at the point p; drops planes whose multiplier would become
 * negative on the way. Empty: no point can satisfy the plane and the active ones together. */
Outcome activate(ActivePlanes& active, Eigen::Index row, Eigen::Vector3d p,
                 const core::HalfSpaces& set)
{
  const Eigen::Vector3d normal = set.A.row(row).transpose();
  double own = 0.0;
  for (;;)
  {
    Eigen::Vector3d share;
    const Eigen::Vector3d rest = active.residual(normal, share);
    const bool independent = active.count < 3 && rest.squaredNorm() > kIndependent;
    const double full = independent ? (normal.dot(p) - set.b[row]) / rest.squaredNorm()
                                    : std::numeric_limits<double>::infinity();
    double step = full;
    int blocking = -1;
    for (int k = 0; k < active.count; ++k)
      if (share[k] > 1e-12 && active.multiplier[k] < step * share[k])
      {
        step = active.multiplier[k] / share[k];
        blocking = k;
      }
    if (!std::isfinite(step)) return Outcome::Empty;
    own += step;
    active.multiplier.head(active.count) -= step * share.head(active.count);
    if (independent) p -= step * rest;
    if (blocking < 0)
    {
      active.add(row, own);
      return Outcome::Added;
    }
    active.drop(blocking);
  }
}
}  // namespace

// Dual active-set method (Goldfarb and Idnani 1983) with unit Hessian: the distance to the active
// planes' intersection grows with every plane, so no active set comes twice.
std::optional<Eigen::Vector3d> project(const Eigen::Vector3d& x, const core::HalfSpaces& set)
{
  if (!x.allFinite()) return std::nullopt;
  ActivePlanes active(x, set);
  Eigen::Vector3d p = x;
  const double tolerance = kFeasible * (1.0 + x.cwiseAbs().maxCoeff());
  const Eigen::Index most_steps = 50 + 10 * set.rows();
  for (Eigen::Index step = 0; step < most_steps; ++step)
  {
    Eigen::Index worst = -1;
    double violation = tolerance;
    for (Eigen::Index i = 0; i < set.rows(); ++i)
      if (const double v = set.A.row(i).dot(p) - set.b[i]; v > violation)
      {
        violation = v;
        worst = i;
      }
    if (worst < 0) return p;
    if (activate(active, worst, p, set) == Outcome::Empty) return std::nullopt;
    p = active.pointOnPlanes();
  }
  return std::nullopt;  // rounding made it circle: nothing that could be called a projection
}

}  // namespace slalom::geometry
