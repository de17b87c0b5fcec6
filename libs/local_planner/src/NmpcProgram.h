// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <vector>

#include "slalom/core/Vehicle.h"
#include "slalom/local_planner/LocalPlannerConfig.h"
#include "slalom/optim/Ipopt.h"

namespace slalom::local_planner::detail
{
/// One row "stay away": normal . p >= offset - slack.
struct KeepOut
{
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();  ///< unit vector obstacle -> free space [1]
  double offset = 0.0;  ///< [m] normal . (obstacle point) + asked-for distance
};

/// What changes from step to step. State = [position (3, m), yaw (rad)], input = [velocity in world
/// axes (3, m/s), yaw rate (rad/s)], one stage per column.
struct NmpcData
{
  Eigen::Vector4d state = Eigen::Vector4d::Zero();       ///< at stage 0, given
  Eigen::Vector4d last_input = Eigen::Vector4d::Zero();  ///< in effect until now
  double elapsed = 0.1;              ///< [s] since last_input; bounds the change of u_0
  Eigen::Matrix4Xd state_reference;  ///< 4x(N+1)
  Eigen::Matrix4Xd input_reference;  ///< 4xN, the velocity feed-forward
  std::vector<KeepOut> keep_outs;    ///< N*rows, those of stage k = 1..N from (k-1)*rows on
};

/** The optimal control problem of one local step [Paper Eq. (9)] by multiple shooting.
 *
 *    min  sum_{k=1}^{N} |x_k - xr_k|_Q^2 + rho s_k
 *         + sum_{k=0}^{N-1} |u_k - ur_k|_R^2 + |u_k - u_{k-1}|_S^2
 *    s.t. x_{k+1} = x_k + dt u_k,  |u_k| <= limits,  |v_k - v_{k-1}| <= a_max dt,
 *         n_kj . (p_k - o_kj) >= D - s_k,  s_k >= 0           (k >= 1)
 *
 *  Velocities are in world axes, so the dynamics are linear and exact for a held input. The
 *  distance |p_k - o_kj| of the paper is linearised where the vehicle is expected to be, which
 *  makes the program convex: one solution, few iterations, no dead ends at obstacles. One slack per
 *  stage serves all its obstacles. Variables: per stage [u_k, x_{k+1}, s_{k+1}], s only with
 *  obstacle rows. @see deviation D-08 (docs/paper_map.md) */
class NmpcProgram : public optim::NonlinearProgram
{
 public:
  NmpcProgram(const LocalPlannerConfig& config, const core::Vehicle& vehicle, int rows_per_stage);

  NmpcData data;

  [[nodiscard]] int stages() const { return stages_; }
  [[nodiscard]] int rowsPerStage() const { return rows_; }

  [[nodiscard]] Eigen::VectorXd pack(const Eigen::Matrix4Xd& states,
                                     const Eigen::Matrix4Xd& inputs) const;
  /// By how much the worst stage of `states` violates its rows [m].
  [[nodiscard]] double neededSlack(const Eigen::Matrix4Xd& states) const;
  [[nodiscard]] Eigen::Matrix4Xd statesOf(const Eigen::VectorXd& x) const;  ///< 4x(N+1)
  [[nodiscard]] Eigen::Matrix4Xd inputsOf(const Eigen::VectorXd& x) const;  ///< 4xN
  [[nodiscard]] double worstSlack(const Eigen::VectorXd& x) const;          ///< [m]

  [[nodiscard]] int variables() const override { return stages_ * stride(); }
  [[nodiscard]] int constraints() const override { return stages_ * (7 + rows_) - 3; }
  void bounds(Eigen::Ref<Eigen::VectorXd> x_lower, Eigen::Ref<Eigen::VectorXd> x_upper,
              Eigen::Ref<Eigen::VectorXd> g_lower,
              Eigen::Ref<Eigen::VectorXd> g_upper) const override;
  [[nodiscard]] std::vector<optim::Entry> jacobianStructure() const override;
  [[nodiscard]] std::vector<optim::Entry> hessianStructure() const override;
  [[nodiscard]] double cost(const Eigen::Ref<const Eigen::VectorXd>& x) const override;
  void gradient(const Eigen::Ref<const Eigen::VectorXd>& x,
                Eigen::Ref<Eigen::VectorXd> grad) const override;
  void constraint(const Eigen::Ref<const Eigen::VectorXd>& x,
                  Eigen::Ref<Eigen::VectorXd> g) const override;
  void jacobian(const Eigen::Ref<const Eigen::VectorXd>& x,
                Eigen::Ref<Eigen::VectorXd> values) const override;
  void hessian(const Eigen::Ref<const Eigen::VectorXd>& x, double sigma,
               const Eigen::Ref<const Eigen::VectorXd>& lambda,
               Eigen::Ref<Eigen::VectorXd> values) const override;

 private:
  [[nodiscard]] double neededSlack(const Eigen::Matrix4Xd& states, int k) const;
  using Point = Eigen::Ref<const Eigen::VectorXd>;
  [[nodiscard]] int stride() const { return rows_ > 0 ? 9 : 8; }
  [[nodiscard]] int input(int k) const { return k * stride(); }            ///< u_k, k = 0..N-1
  [[nodiscard]] int state(int k) const { return (k - 1) * stride() + 4; }  ///< x_k, k = 1..N
  [[nodiscard]] int slack(int k) const { return (k - 1) * stride() + 8; }  ///< s_k, k = 1..N
  /// First row of the dynamics into stage k + 1; its obstacle rows follow, then (k >= 1) the three
  /// rows of acceleration.
  [[nodiscard]] int row(int k) const { return k * (7 + rows_) - (k > 0 ? 3 : 0); }
  [[nodiscard]] Eigen::Vector4d previousInput(const Point& x, int k) const
  {
    return k == 0 ? data.last_input : Eigen::Vector4d(x.segment<4>(input(k - 1)));
  }
  [[nodiscard]] const KeepOut& keepOut(int k, int j) const
  {
    return data.keep_outs[static_cast<std::size_t>((k - 1) * rows_ + j)];
  }
  /// Both walks call visit(row, col, value) for each entry, always in the same order.
  template <class Visit>
  void walkJacobian(Visit&& visit) const;
  template <class Visit>
  void walkHessian(double sigma, Visit&& visit) const;

  int stages_, rows_;
  double step_, penalty_, max_change_;
  Eigen::Vector4d q_, r_, s_, limit_;
  std::vector<optim::Entry> jacobian_structure_, hessian_structure_;
};

}  // namespace slalom::local_planner::detail
