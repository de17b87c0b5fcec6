// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "Draft.h"
#include "Refinement.h"
#include "slalom/global_planner/GlobalPlanner.h"

namespace slalom::global_planner
{
/** The working set of one GlobalPlanner::step(): which drafts there are, what comes of them, and
 * what is committed. */
class PlanStep
{
 public:
  PlanStep(const GlobalPlannerConfig& config, const core::Vehicle& vehicle,
           const GlobalPlannerInput& input);

  GlobalPlannerOutput run();

 private:
  /// What came of leading one draft around everything.
  struct Attempt
  {
    std::optional<Refinement> best;
    std::string reason;             ///< one line: what was done, or why nothing came of it
    Draft draft;                    ///< as it was before
    std::optional<Bypass> blocked;  ///< no way around here ...
    bool unreachable = false;       ///< ... since its end is cut off
    Eigen::Vector3d nearest_L = Eigen::Vector3d::Zero();  ///< reachable point nearest to that end
    bool led_around = false;
    core::RefinementRecord failed;  ///< explains the last way that was not accepted

    static Attempt none(std::string reason, Draft draft)
    {
      Attempt attempt;
      attempt.reason = std::move(reason);
      attempt.draft = std::move(draft);
      return attempt;
    }
  };

  void keepMargin(double margin_m);
  [[nodiscard]] bool mustRestart() const;
  [[nodiscard]] bool endsHere() const;
  [[nodiscard]] Draft begin() const;
  [[nodiscard]] double joinTime() const;
  [[nodiscard]] bool isChallenged(const Refinement& plan) const;
  [[nodiscard]] Attempt attempt(Draft draft, const std::vector<Bypass>& bypasses) const;
  void tryWay(Attempt& attempt, const std::vector<Bypass>& bypasses,
              const std::vector<Eigen::Matrix3Xd>& guides, const std::string& name) const;
  [[nodiscard]] Attempt followPlan() const;
  [[nodiscard]] Attempt returnToReference(const Draft& from) const;
  [[nodiscard]] Attempt approach(const Attempt& failed, PlanEnd end) const;
  [[nodiscard]] Attempt leadOn() const;
  void comeNear(Attempt& plan);
  void classifyGoal();
  [[nodiscard]] GoalReport goalFrom(const RefinedReference& plan) const;
  [[nodiscard]] GlobalPlannerOutput commit(const Attempt& attempt, RefineOutcome outcome);
  [[nodiscard]] GlobalPlannerOutput keep(Attempt failed, RefineOutcome outcome);
  [[nodiscard]] std::vector<double> tightSpeeds(const spline::UniformBSpline& curve, double from,
                                                double pace) const;
  [[nodiscard]] RefinedReference promise(const spline::UniformBSpline& curve, Eigen::VectorXd along,
                                         double clear_until) const;

  const GlobalPlannerInput& in_;
  const GlobalPlannerConfig config_;
  const core::Vehicle& vehicle_;
  const core::DistanceField& field_;
  const spline::UniformBSpline& r_;
  const RefinedReference* previous_;
  double rho_;  // parameter of R that the vehicle is at
  bool restart_ = false;
  bool holds_ = false;  // the goal is blocked: the plan ends as near to it as it can be
  StepContext context_;
  GoalReport goal_;
};

}  // namespace slalom::global_planner
