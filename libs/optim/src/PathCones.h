// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <vector>

#include "PathPart.h"

namespace slalom::optim::detail
{
/** The terms w |v| of PathSocp as second-order cones, in primal-dual form with Nesterov-Todd
 * scaling.
 *
 *  Term e costs w t_e with s = (t_e, v_e) in the cone { |v| <= t }, v_e = p_to - p_from (the wanted
 * ends stand for the points before the first and behind the last). Its multiplier is (w, -y),
 * |y| <= w: the first component never changes, so t is eliminated exactly, and what remains is a
 * spring of stiffness M (3x3) between two points, stiff across v and soft along it. */
class PathCones final : public PathPart
{
 public:
  PathCones(const Eigen::Vector3d& first, const Eigen::Vector3d& last, Eigen::Index points,
            double w_start, double w_end, double w_length);

  [[nodiscard]] double cost(const Eigen::Matrix3Xd& p) const;
  /// y of every term, in order.
  [[nodiscard]] Eigen::Matrix3Xd tensions() const;
  /// sum w |v| - y.v
  [[nodiscard]] double multiplierSlack(const Eigen::Matrix3Xd& p) const;

  void initialize(const Eigen::Matrix3Xd& p, double length, double price) override;
  PartState linearize(const Eigen::Matrix3Xd& p, BlockBand& matrix,
                      Eigen::Matrix3Xd& gradient) override;
  void addRightHandSide(double centre, bool corrected, Eigen::Matrix3Xd& rhs) override;
  Reach expand(const Eigen::Matrix3Xd& dp) override;
  void move(double step) override;

 private:
  struct Cone
  {
    double weight = 0.0;
    Eigen::Vector4d s, z;  // z = (weight, -y)
    Eigen::Vector4d ds = Eigen::Vector4d::Zero(), dz = Eigen::Vector4d::Zero();
    // Scaling W = eta [w0 w1'; w1 I + w1 w1' / (1 + w0)] with W z = W^-1 s = lambda.
    double eta = 1.0, softness = 1.0;  // softness: of the stiffness along w1, relative to across
    Eigen::Vector4d w, lambda, q;
    Eigen::Matrix3d stiffness;

    void scale();
    [[nodiscard]] Eigen::Vector4d times(const Eigen::Vector4d& x) const;    // W x
    [[nodiscard]] Eigen::Vector4d divided(const Eigen::Vector4d& x) const;  // W^-1 x
  };
  /// v of term e, given positions (or their changes, with the ends at rest).
  [[nodiscard]] Eigen::Vector3d span(const Eigen::Matrix3Xd& p, std::size_t e,
                                     const Eigen::Vector3d& first,
                                     const Eigen::Vector3d& last) const;
  /// Adds the pull `force` of term e along v to its two points.
  static void addPull(Eigen::Matrix3Xd& at, std::size_t e, const Eigen::Vector3d& force);

  Eigen::Vector3d first_, last_;
  std::vector<Cone> cones_;
};

}  // namespace slalom::optim::detail
