// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "slalom/core/CycleRecord.h"
#include "slalom/engine/Engine.h"

namespace slalom::engine
{
/** Tells changes: a status that was not there the cycle before, SAFE_STOP when the vehicle begins
 * to brake for a reason of safety, RECOVER when it has flown on for ten cycles after that, so that
 * a fault that comes and goes is one stop and not many. */
class FlightEvents
{
 public:
  /// What a cycle came to.
  struct Facts
  {
    double t;  ///< [s]
    EngineStatus status;
    bool driven;         ///< there is a mission, and the vehicle is allowed to fly it
    std::string unsafe;  ///< why safety makes it brake; empty: it does not
    bool waiting;        ///< it cannot begin yet; for more than a second, that is unsafe too
    std::string reason;  ///< one line: why this command
  };

  [[nodiscard]] std::vector<core::Event> update(const Facts& facts);

  [[nodiscard]] std::uint64_t safeStops() const { return safe_stops_; }
  [[nodiscard]] std::uint64_t recoveries() const { return recoveries_; }

 private:
  [[nodiscard]] std::string unsafe(const Facts& facts);

  std::optional<EngineStatus> status_;
  std::optional<double> waiting_since_;
  bool stopped_ = false;
  int good_cycles_ = 0;
  std::uint64_t safe_stops_ = 0, recoveries_ = 0;
};

}  // namespace slalom::engine
