// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "FlightPlan.h"

namespace slalom::experiment
{
/// What is written beside a flight's output when slalom-fly has ended: `flight.json`.
struct FlightRecord
{
  std::string key;  ///< PlannedFlight::key
  int code = -1;    ///< exit code; 128 + signal if it was killed
  double wall_s = 0.0;
};

/** The record of a flight that ended by itself, with these very settings.
 *  @return nullopt if it was not flown, was interrupted, crashed, refused its arguments, or was
 * flown with other settings or another build */
[[nodiscard]] std::optional<FlightRecord> finishedFlight(const PlannedFlight& flight);

/** Flies, one process of slalom-fly per flight, `jobs` at a time. A flight's folder gets what
 * slalom-fly writes, `log.txt` (its stdout and stderr), `memory.csv` (`t_s,rss_mb`, once a second)
 * and, at the end, `flight.json`. After Ctrl-C the running flights are asked to finish, and no
 * other is begun.
 *  @param ended is called after each flight
 *  @return false if it was interrupted
 *  @throws std::runtime_error if a process cannot be begun */
bool flyAll(const std::vector<const PlannedFlight*>& flights, const std::filesystem::path& program,
            int jobs, const std::function<void(const PlannedFlight&, const FlightRecord&)>& ended);

}  // namespace slalom::experiment
