// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <memory>

#include "HorizonReference.h"
#include "KeepOuts.h"
#include "Plan.h"
#include "slalom/optim/TrackingQp.h"

namespace slalom::local_planner::detail
{
/// What an NMPC step starts from.
struct NmpcStart
{
  double t = 0.0;                                        ///< [s] log time
  core::Motion motion;                                   ///< when the command takes effect
  Eigen::Vector4d last_input = Eigen::Vector4d::Zero();  ///< in effect until then, within limits
  double elapsed = 0.1;                                  ///< [s] since it; bounds the first change
};

/** The optimal control problem of one local step [Paper Eq. (9)] as two convex programs: the motion
 *  and, independent of it, the heading.
 *
 *    min  sum_{k=1}^{N} |p_k - pr_k|_Q^2 + q |v_k - vr_k|^2 + r |u_{k-1} - ur_{k-1}|^2
 *         + s |u_k - u_{k-1} - dr_k|^2 + rho slack
 *    s.t. the lag model, |u| <= limits, |u_k - u_{k-1}| <= a_max dt, rows of keepOuts()
 *
 *  Q weighs the error across the reference and along it apart; the last stage stands for what comes
 *  after. Velocities are in world axes, so the dynamics are linear and exact for held inputs, and
 *  distances are linearised: one solution, few iterations, no dead ends at obstacles. Without lag
 *  this is the kinematic model of the paper. @see deviation D-08 (docs/paper_map.md) */
class Nmpc
{
 public:
  Nmpc(const LocalPlannerConfig& config, const core::Vehicle& vehicle);

  struct Result
  {
    Plan plan;
    core::SolveReport report;
    double worst_slack = 0.0;  ///< [m]
  };
  /// @param guess commands to start from, and where obstacles were looked for
  [[nodiscard]] Result solve(const NmpcStart& start, const HorizonReference& reference,
                             const KeepOuts& keep_outs, const Plan& guess, const Model& model,
                             const core::Deadline& deadline);

 private:
  void setMotion(const NmpcStart& start, const HorizonReference& reference, const Plan& guess,
                 const Model& model);
  void setRows(const KeepOuts& keep_outs);
  void setHeading(const NmpcStart& start, const HorizonReference& reference);

  LocalPlannerConfig config_;
  optim::TrackingQp<3> motion_;
  optim::TrackingQp<1> heading_;
  std::unique_ptr<optim::TrackingSolver<3>> motion_solver_;
  std::unique_ptr<optim::TrackingSolver<1>> heading_solver_;
};

}  // namespace slalom::local_planner::detail
