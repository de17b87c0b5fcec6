// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <limits>
#include <memory>

#include "Pipeline.h"
#include "slalom/core/CycleRecord.h"
#include "slalom/engine/EngineConfig.h"
#include "slalom/global_planner/GlobalPlanner.h"

namespace slalom::engine
{
/// The engine's side of the global planner: when to ask it, and its newest answer.
class Refinements
{
 public:
  explicit Refinements(double period_s) : period_s_(period_s) {}

  void restart() { *this = Refinements(period_s_, seen_); }  ///< a new mission begins
  void forgetPlan() { refined_.reset(); }
  /// The local frame began anew: the plan is void, the answer under way too.
  void forgetFrame() { refined_.reset(), waiting_ = false; }

  /// Asks at most once per period and map, and one request at a time: the next one continues the
  /// plan that comes of this one.
  [[nodiscard]] bool due(const MapResult& map, double t) const;
  void asked(const MapResult& map, double t);
  /// The answer that has come since the last call, taken over; null if there is none for `mission`.
  std::shared_ptr<const GlobalResult> take(const Pipeline& pipeline, std::uint64_t mission);

  /// The refined reference in force; null: none yet.
  [[nodiscard]] const std::shared_ptr<const global_planner::RefinedReference>& refined() const
  {
    return refined_;
  }
  [[nodiscard]] global_planner::RefineOutcome outcome() const { return outcome_; }
  [[nodiscard]] const global_planner::GoalReport& goal() const { return goal_; }
  [[nodiscard]] const core::RefinementRecord& explanation() const { return explanation_; }
  /// The goal is occupied and the mission is not to be flown at all.
  [[nodiscard]] bool rejectsGoal(global_planner::GoalPolicy policy) const;
  /// The planner found no plan of its own; the previous one stays in force.
  [[nodiscard]] bool failed() const;
  /// Since the map of the newest answer was looked at [s]; infinite without an answer.
  [[nodiscard]] double age(double t) const { return t - answered_t_; }
  /// How long the planner has been asked without an answer [s].
  [[nodiscard]] double silence(double t) const { return waiting_ ? t - waiting_since_ : 0.0; }

 private:
  Refinements(double period_s, std::uint64_t seen) : period_s_(period_s), seen_(seen) {}

  double period_s_;
  std::uint64_t seen_ = 0, asked_map_ = 0;
  bool waiting_ = false;
  double waiting_since_ = 0.0;  // [s] first request without an answer
  double asked_t_ = -std::numeric_limits<double>::infinity();
  double answered_t_ = asked_t_;  // [s] when the question of the newest answer was put
  std::shared_ptr<const global_planner::RefinedReference> refined_;
  global_planner::RefineOutcome outcome_ = global_planner::RefineOutcome::NoField;
  global_planner::GoalReport goal_;
  core::RefinementRecord explanation_;
};

}  // namespace slalom::engine
