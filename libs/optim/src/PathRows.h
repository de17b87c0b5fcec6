// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <vector>

#include "PathPart.h"
#include "slalom/optim/PathSets.h"

namespace slalom::optim::detail
{
/** The half-space rows a.p <= b of a chain with their interior-point state.
 *
 *  Each row reads  a.p - b - xi + s = 0  with s >= 0 (multiplier z), and its relaxation xi is
 *    Hard     absent,
 *    Capped   priced w xi^2 and xi + t = cap with t >= 0 (multiplier u); xi >= 0 needs no row,
 *             because the price alone keeps xi = max(0, a.p - b),
 *    Elastic  priced w xi^2 and free.
 *  All of s, z, xi, t, u are eliminated: a 3x3 term per point is left.
 *
 *  Rows of a point lie side by side in lanes of four; the last lanes are filled up with 0.p <= 1,
 * which always holds. */
class PathRows final : public PathPart
{
 public:
  enum class Relaxation
  {
    Hard,
    Capped,
    Elastic
  };

  /// The rows of `sets` seen from `origin`, tightened by `tighten`.
  PathRows(const PathSets& sets, const Eigen::Vector3d& origin, double tighten,
           Relaxation relaxation, double weight, double cap);

  /// Number of rows, with those that fill up the lanes.
  [[nodiscard]] Eigen::Index size() const { return 4 * static_cast<Eigen::Index>(lanes_.size()); }

  void initialize(const Eigen::Matrix3Xd& p, double length, double price) override;
  PartState linearize(const Eigen::Matrix3Xd& p, BlockBand& matrix,
                      Eigen::Matrix3Xd& gradient) override;
  void addRightHandSide(double centre, bool corrected, Eigen::Matrix3Xd& rhs) override;
  Reach expand(const Eigen::Matrix3Xd& dp) override;
  void move(double step) override;

  [[nodiscard]] double relaxationCost() const;
  /// sum z (b - a.p): what the multipliers still lack of certainty.
  [[nodiscard]] double multiplierSlack(const Eigen::Matrix3Xd& p) const;

 private:
  using Four = Eigen::Array4d;
  struct Lanes
  {
    Four nx = Four::Zero(), ny = Four::Zero(), nz = Four::Zero(), bound = Four::Ones();
    Four s = Four::Ones(), z = Four::Ones(), xi = Four::Zero(), t = Four::Ones(), u = Four::Zero();
    Four ds = Four::Zero(), dz = Four::Zero(), dxi = Four::Zero();
    Four dt = Four::Zero(), du = Four::Zero();
    Four r_c = Four::Zero(), r_xi = Four::Zero(), r_t = Four::Zero();  // residuals of the rows
    Four c_s = Four::Zero(), c_t = Four::Zero();                       // residuals of s z and t u
    Four over_s = Four::Ones(), over_t = Four::Ones(), over_stiffness = Four::Ones();
    Four w = Four::Zero(), e = Four::Zero();  // dz = e + w (a.dp)

    [[nodiscard]] Four along(const Eigen::Vector3d& v) const
    {
      return nx * v.x() + ny * v.y() + nz * v.z();
    }
  };
  struct Group  // the lanes of one point
  {
    Eigen::Index point;
    std::size_t begin, end;
  };

  template <Relaxation kind>
  PartState linearizeAs(const Eigen::Matrix3Xd& p, BlockBand& matrix, Eigen::Matrix3Xd& gradient);
  template <Relaxation kind>
  void addRightHandSideAs(double centre, double corrected, Eigen::Matrix3Xd& rhs);
  template <Relaxation kind>
  Reach expandAs(const Eigen::Matrix3Xd& dp);
  template <class Call>
  auto dispatch(Call&& call);

  Relaxation relaxation_;
  double weight_, cap_;
  std::vector<Lanes> lanes_;
  std::vector<Group> groups_;
};

}  // namespace slalom::optim::detail
