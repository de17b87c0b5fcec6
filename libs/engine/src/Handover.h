// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>

#include "Flight.h"
#include "Pipeline.h"
#include "Refinements.h"
#include "StateSource.h"
#include "slalom/local_planner/LocalPlanner.h"

namespace slalom::engine
{
/// Why the vehicle is to come to rest instead of following a plan.
struct Hold
{
  enum class Kind
  {
    None,
    Wanted,   ///< it has nothing to do
    Waiting,  ///< it cannot begin yet
    Safety    ///< it must not go on: something it relies on is too old
  };
  Kind kind = Kind::None;
  std::string reason;
};

/// What the decision looks at.
struct Situation
{
  const EngineConfig& config;
  const Flight& flight;
  const Refinements& refinements;
  const StateSource& source;
  std::shared_ptr<const MapResult> map;  ///< of the present frame; null: none yet
  double t;                              ///< [s] now
  double state_t;                        ///< [s] of the newest estimate
  bool blocked;                          ///< as near to a goal that cannot be had as it will come
  bool stuck;                            ///< it does not move although it is told to
  bool refused;                          ///< the newest scan contradicts the map
  bool mapped;                           ///< there has been a map, if only of another frame
  std::string slow;  ///< why scans come too rarely to fly by; empty: they do not
};

/** Chooses what the local planner follows, and in which map: fills field, reference and law of
 * `input`, or leaves them empty and says why. */
[[nodiscard]] Hold handOver(const Situation& situation, local_planner::LocalPlannerInput& input);

}  // namespace slalom::engine
