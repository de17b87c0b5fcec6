// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

namespace slalom::optim::detail
{
/** Log barriers and multipliers of lower <= v <= upper, as a primal-dual interior point needs them:
 * v enters its linear system with `stiffness` on the diagonal and `push` on the right-hand side.
 * Sides at infinity have no barrier; entries with no room between their bounds have none and are to
 * be held by the caller. */
class Barrier
{
 public:
  Barrier(Eigen::ArrayXd lower, Eigen::ArrayXd upper);

  /// Number of sides that have a barrier.
  [[nodiscard]] double sides() const { return sides_; }
  [[nodiscard]] bool held(Eigen::Index i) const { return held_[i] != 0.0; }
  [[nodiscard]] const Eigen::ArrayXd& value() const { return v_; }

  /// Puts v inside, no nearer to a bound than `share` of the room, and centres the multipliers.
  void start(const Eigen::Ref<const Eigen::ArrayXd>& v, double share, double mu);
  /// Sum of slack times multiplier, now and after steps along the last direction.
  [[nodiscard]] double complementarity() const;
  [[nodiscard]] double complementarityAfter(double primal_step, double dual_step) const;

  /// Takes the linear system at v, with a right-hand side for the centre 0.
  void linearize();
  /// Takes the right-hand side for a centre mu and the second-order terms of the last direction
  /// (Mehrotra).
  void correct(double mu);
  [[nodiscard]] const Eigen::ArrayXd& stiffness() const { return stiffness_; }
  [[nodiscard]] const Eigen::ArrayXd& push() const { return push_; }
  /// upper minus lower multipliers: the force of the bounds against v.
  [[nodiscard]] auto force() const { return upper_z_ - lower_z_; }

  /// The direction of the multipliers that belongs to dv.
  void expand(const Eigen::Ref<const Eigen::ArrayXd>& dv);
  void limitSteps(double& primal_step, double& dual_step) const;
  void move(double primal_step, double dual_step);

 private:
  Eigen::ArrayXd lower_, upper_;
  Eigen::ArrayXd has_lower_, has_upper_, held_;  // 0 or 1
  double sides_ = 0.0;
  Eigen::ArrayXd v_, lower_s_, upper_s_, lower_z_, upper_z_;  // slacks (1 if no side), multipliers
  Eigen::ArrayXd lower_i_, upper_i_;                          // inverse slacks of the linear system
  Eigen::ArrayXd dv_, lower_dz_, upper_dz_;
  Eigen::ArrayXd lower_c_, upper_c_;  // wanted products of slack and multiplier
  Eigen::ArrayXd stiffness_, push_;
};

}  // namespace slalom::optim::detail
