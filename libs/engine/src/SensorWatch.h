// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>

#include "StateSource.h"
#include "slalom/engine/EngineConfig.h"

namespace slalom::engine
{
/** Says since when a mission has not been able to rely on its sensors. A sensor that is heard, but
 * less often than its time-out, is one that nothing can be flown by: it is silent too. */
class SensorWatch
{
 public:
  explicit SensorWatch(const EngineConfig& config) : config_(config) {}

  /// @param end_t log time of a scan that has come [s]
  void heardScan(const std::string& label, double end_t);
  /// The last two scans came farther apart than safety.map_timeout_s: why that is too slow. Else
  /// empty.
  [[nodiscard]] std::string slowScans() const;

  /** One cycle of a mission that is to be flown; reset() in any other.
   *  @param map_age_s how old the map is that it is flown by; infinite: there is none yet, empty:
   * it needs none
   *  @return empty, or which sensor has been missed for longer than mission.sensor_timeout_s */
  [[nodiscard]] std::string missing(double t, const StateSource& source,
                                    std::optional<double> map_age_s);
  void reset() { since_.reset(); }

 private:
  [[nodiscard]] std::string complaint(double t, const StateSource& source,
                                      std::optional<double> map_age_s) const;

  const EngineConfig& config_;
  std::string label_;  // of the last scan
  std::optional<double> scan_t_;
  double interval_s_ = 0.0;      // between the last two scans
  std::optional<double> since_;  // [s] something is missing
};

}  // namespace slalom::engine
