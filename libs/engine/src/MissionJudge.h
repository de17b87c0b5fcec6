// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <limits>

#include "Flight.h"
#include "Refinements.h"
#include "slalom/core/CycleRecord.h"
#include "slalom/engine/Engine.h"

namespace slalom::engine
{
constexpr double kAtRest_mps = 0.1;  ///< a slower vehicle rests

/// Says what has become of a mission.
class MissionJudge
{
 public:
  explicit MissionJudge(const EngineConfig& config) : config_(config) {}

  void restart()
  {
    standing_s_ = wandering_s_ = 0.0;
    farthest_ = -std::numeric_limits<double>::infinity();
    forgetBlockage();
  }
  /// The goal cannot be had, and the vehicle has come as near as it will: it stays where it is.
  [[nodiscard]] bool blocked() const { return blocked_; }

  /** @param on_reference parameter of R that the vehicle has come to [s]
   *  @param dt since the last cycle [s]; @param could_go nothing but the way itself keeps it from
   * moving */
  [[nodiscard]] EngineStatus judge(Flight& flight, const Refinements& refinements,
                                   double on_reference, const core::CycleRecord& record, double dt,
                                   bool could_go);

 private:
  [[nodiscard]] bool holdsBefore(const Refinements& refinements, const Eigen::Vector3d& p_L,
                                 bool rests) const;
  void judgeBlockage(const Refinements& refinements, bool holds, double distance_m, double dt,
                     bool could_go);
  void forgetBlockage()
  {
    blocked_ = false;
    held_s_ = hopeless_s_ = leading_s_ = 0.0;
    nearest_m_ = std::numeric_limits<double>::infinity();
  }

  const EngineConfig& config_;
  bool blocked_ = false;
  double held_s_ = 0.0;      // how long the vehicle has held before a goal that is blocked
  double hopeless_s_ = 0.0;  // how long it has come no nearer, and no plan has led to the goal
  double leading_s_ = 0.0;   // for how long plans have led to the goal
  double nearest_m_ = std::numeric_limits<double>::infinity();  // that it has come to the goal
  double standing_s_ = 0.0;   // how long the vehicle has stood although the mission is not over
  double wandering_s_ = 0.0;  // how long it has come no farther on R
  double farthest_ =
      -std::numeric_limits<double>::infinity();  // parameter of R that the vehicle has come to [s]
};

}  // namespace slalom::engine
