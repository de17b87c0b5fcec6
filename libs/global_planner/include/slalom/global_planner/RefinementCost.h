// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <vector>

#include "slalom/core/Vehicle.h"
#include "slalom/global_planner/GlobalPlannerConfig.h"
#include "slalom/optim/BandedCost.h"

namespace slalom::global_planner
{
/// One pull on one control point: stay at least D_z from `anchor_L` in the direction `normal_L`.
struct Push
{
  Eigen::Index point = 0;    ///< column in the window
  Eigen::Vector3d anchor_L;  ///< on the obstacle's surface [m]
  Eigen::Vector3d normal_L;  ///< unit vector, obstacle -> free space [1]
};

/// What the penalty is beyond D_z inside the obstacle, where the cube grows fast.
enum class HingeTail
{
  Quadratic,  ///< continued twice differentiably by a parabola (deviation D-03)
  Cubic       ///< the cube everywhere, as printed
};

struct Penalty
{
  double cost = 0.0;       ///< [m^3]
  double slope = 0.0;      ///< derivative along the push's normal [m^2]; the gradient is slope n
  double curvature = 0.0;  ///< second derivative along it [m]; the Hessian is curvature n n^T
};

/** Cubic hinge for a control point closer than `clearance` to its anchor.
 *
 *  With e = clearance - (p - anchor).n the cost is e^3 for 0 < e <= clearance, quadratic beyond (C2
 * join), 0 for e <= 0.
 *
 *  @param p_L        control point, local frame [m]
 *  @param clearance  D_z [m], > 0
 *  @return cost [m^3] and its exact derivatives; finite for finite input
 *  @see [Paper Eq. (4)]; deviation D-03 (docs/paper_map.md). */
[[nodiscard]] Penalty clearancePenalty(const Eigen::Vector3d& p_L, const Push& push,
                                       double clearance, HingeTail tail = HingeTail::Quadratic);

/** J = l_smooth J_smooth + l_obs J_obs + l_feas J_feas + l_fit J_fit over the control points of one
 * window [Paper Eq. (1)].
 *
 *    J_smooth  sum |c_{i+2} - 2 c_{i+1} + c_i - bend_i|^2                   [Eq. (6), D-07]
 *    J_obs     sum of clearancePenalty                                      [Eq. (4), D-03]
 *    J_feas    per axis ((|v|-v_max)_+ / D)^2 and ((|a|-a_max)_+)^2         [Eq. (7)-(8), D-06]
 *    J_fit     sum w_i (|x.t|^2 / 25 + |x cross t|^2), x the offset of the curve from R at knot i,
 *              t the tangent of R                                           [D-07]
 *
 *  Columns before `first_free` and behind `last_free` are fixed; the variables are the free
 * columns, stacked. J is convex, C1 and piecewise C2; gradient and curvature are exact (at a kink
 * of the gradient the curvature is that of one side). */
class RefinementCost final : public optim::LimitedCost
{
 public:
  struct Problem
  {
    Eigen::Matrix3Xd points;     ///< 3xN window, start values; fixed columns keep theirs
    Eigen::Matrix3Xd reference;  ///< 3xN control points of R in the same window
    Eigen::VectorXd fit_weight;  ///< N, 0 where R itself is occupied
    Eigen::Index first_free = 0, last_free = 0;
    double knot_span = 0.2;  ///< [s]
    Eigen::Matrix3Xd bend;   ///< 3x(N-2) second differences that cost nothing: those of R where the
                             ///< plan is to be R; empty = none
    std::vector<Push> pushes;
    double obstacle_gain = 1.0;  ///< multiplies lambda_obs; larger in later attempts
    HingeTail tail = HingeTail::Quadratic;
  };

  RefinementCost(Problem problem, const GlobalPlannerConfig& config, const core::Vehicle& vehicle);

  /// J without J_feas.
  [[nodiscard]] double evaluateSmooth(const Eigen::VectorXd& x, Eigen::VectorXd& gradient) override;
  void curvatureSmooth(const Eigen::VectorXd& x, optim::BlockBand& hessian) override;

  [[nodiscard]] Eigen::VectorXd start() const;  ///< the free columns of the problem
  [[nodiscard]] Eigen::Matrix3Xd points(
      const Eigen::VectorXd& x) const;  ///< whole window with x put in

 private:
  /// J_fit at one knot is x^T metric x, x the offset of the curve from R.
  struct Fit
  {
    Eigen::Index point;
    Eigen::Matrix3d metric;
  };

  void makeFits(double weight);
  void makeConstantCurvature();
  double smoothness();
  double obstacles();
  double fitness();

  Problem problem_;
  Eigen::Index free_;  // columns that are variables
  double clearance_, weight_smooth_, weight_obs_;
  std::vector<Fit> fits_;
  optim::BlockBand constant_;         // curvature of J_smooth and J_fit
  Eigen::Matrix3Xd work_, gradient_;  // whole window
  Eigen::ArrayXd bend_;               // second differences, all axes in one array
};

}  // namespace slalom::global_planner
