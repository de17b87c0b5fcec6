// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/core/Clock.h>

#include <map>
#include <optional>
#include <string>

namespace slalom::mrpt_io::detail
{
/** Turns stamps into log time and decides which stamps to believe.
 *
 *  A stamp is believed when it lies within a minute of its own sensor's last stamp or of the latest
 *  stamp of any sensor. A longer jump forward is believed once the sensor repeats it three times
 *  while no other sensor contradicts (a pause of the recording); clocks that disagree by years, and
 *  single broken stamps, are not. */
class ObservationClock
{
 public:
  /// Log time [s]; nothing when the stamp is missing or not believed (`reason` says why).
  [[nodiscard]] std::optional<double> believe(const std::string& sensor,
                                              const mrpt::Clock::time_point& stamp,
                                              std::string& reason);
  /// Log time of a stamp without judging it; fixes the epoch at the first call.
  [[nodiscard]] double logTime(const mrpt::Clock::time_point& stamp);
  /// Unix time of log time 0 [s]; 0 before the first stamp.
  [[nodiscard]] double epoch() const;

 private:
  struct Sensor
  {
    std::optional<double> last, pending;
    int repeated = 0;
    std::uint64_t accepted_then = 0;  ///< accepted_ when `pending` began
  };
  [[nodiscard]] bool believable(Sensor& sensor, double t) const;

  std::optional<mrpt::Clock::time_point> epoch_;
  std::map<std::string, Sensor> sensors_;
  std::optional<double> latest_;
  std::uint64_t accepted_ = 0;
};

}  // namespace slalom::mrpt_io::detail
