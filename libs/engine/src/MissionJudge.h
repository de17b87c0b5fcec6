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
  }

  /** @param on_reference parameter of R that the vehicle has come to [s]
   *  @param dt since the last cycle [s]; @param could_go nothing but the way itself keeps it from
   * moving */
  [[nodiscard]] EngineStatus judge(Flight& flight, const Refinements& refinements,
                                   double on_reference, const core::CycleRecord& record, double dt,
                                   bool could_go);

 private:
  const EngineConfig& config_;
  double standing_s_ = 0.0;   // how long the vehicle has stood although the mission is not over
  double wandering_s_ = 0.0;  // how long it has come no farther on R
  double farthest_ =
      -std::numeric_limits<double>::infinity();  // parameter of R that the vehicle has come to [s]
};

}  // namespace slalom::engine
