// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <vector>

#include "BlockBandCholesky.h"

namespace slalom::optim::detail
{
/** The half-space rows a.p <= b of a chain with their interior-point state.
 *
 *  Each row reads  a.p - b - xi + s = 0  with s >= 0 (multiplier z), and its relaxation xi is
 *    Hard     absent,
 *    Capped   priced w xi^2 and xi + t = cap with t >= 0 (multiplier u); xi >= 0 needs no row,
 *             because the price alone keeps xi = max(0, a.p - b),
 *    Elastic  priced w xi^2 and free.
 *  All of s, z, xi, t, u are eliminated: condense() leaves a 3x3 term per point. */
class PathQpRows
{
 public:
  enum class Relaxation
  {
    Hard,
    Capped,
    Elastic
  };

  PathQpRows(Relaxation relaxation, double weight, double cap)
      : relaxation_(relaxation), weight_(weight), cap_(cap)
  {
  }
  void add(Eigen::Index point, const Eigen::Vector3d& normal, double bound);
  [[nodiscard]] Eigen::Index size() const { return static_cast<Eigen::Index>(rows_.size()); }

  /// Strictly interior s, z (t, u); `length` and `price` are typical sizes of s and z.
  void initialize(const Eigen::Matrix3Xd& p, double length, double price);
  void updateResiduals(const Eigen::Matrix3Xd& p);

  /// Mean complementarity; 0 without rows.
  [[nodiscard]] double mu() const;
  [[nodiscard]] double primalResidual() const;
  [[nodiscard]] double multiplierResidual() const;  ///< of the stationarity in xi
  [[nodiscard]] double largestMultiplier() const;
  [[nodiscard]] double relaxationCost() const;
  /// gradient += A^T z
  void addMultipliers(Eigen::Matrix3Xd& gradient) const;

  /// matrix += A^T W A; call once per iteration, before the right-hand sides.
  void condense(BlockBand& matrix);
  /// rhs -= A^T e for the target s z = t u = centre, minus the second-order term of the last
  /// direction if `corrected`.
  void addRightHandSide(double centre, bool corrected, Eigen::Matrix3Xd& rhs);
  /// Direction of s, z, xi, t, u that belongs to dp.
  void expand(const Eigen::Matrix3Xd& dp);
  /// Largest step in [0, 1] that keeps s, z, t, u >= 0.
  [[nodiscard]] double longestStep() const;
  [[nodiscard]] double muAfter(double step) const;
  void move(double step);

 private:
  struct Row
  {
    Eigen::Index point;
    Eigen::Vector3d normal;
    double bound;
    double s = 1.0, z = 1.0, xi = 0.0, t = 1.0, u = 0.0;
    double ds = 0.0, dz = 0.0, dxi = 0.0, dt = 0.0, du = 0.0;
    double r_c = 0.0, r_xi = 0.0, r_t = 0.0;  // residuals of the rows above
    double c_s = 0.0, c_t = 0.0;              // residuals of s z and t u
    double w = 0.0, e = 0.0;                  // dz = e + w (a.dp)
  };
  [[nodiscard]] bool capped() const { return relaxation_ == Relaxation::Capped; }
  [[nodiscard]] double pairs() const
  {
    return static_cast<double>(size()) * (capped() ? 2.0 : 1.0);
  }

  Relaxation relaxation_;
  double weight_, cap_;
  std::vector<Row> rows_;
};

}  // namespace slalom::optim::detail
