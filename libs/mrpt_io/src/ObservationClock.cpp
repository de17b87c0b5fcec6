// SPDX-License-Identifier: BSD-3-Clause
#include "ObservationClock.h"

#include <algorithm>
#include <chrono>
#include <cmath>

namespace slalom::mrpt_io::detail
{
namespace
{
constexpr double kLongestJump = 60.0;  // [s]
constexpr int kRepetitions = 3;
}  // namespace

double ObservationClock::logTime(const mrpt::Clock::time_point& stamp)
{
  if (!epoch_) epoch_ = stamp;
  return std::chrono::duration<double>(stamp - *epoch_).count();
}

double ObservationClock::epoch() const
{
  return epoch_ ? mrpt::Clock::toDouble(*epoch_) : 0.0;
}

std::optional<double> ObservationClock::believe(const std::string& sensor,
                                                const mrpt::Clock::time_point& stamp,
                                                std::string& reason)
{
  if (stamp.time_since_epoch().count() <= 0)
  {
    reason = "no time stamp";
    return std::nullopt;
  }
  const double t = logTime(stamp);
  Sensor& s = sensors_[sensor];
  if (!believable(s, t))
  {
    reason = "time jump";
    return std::nullopt;
  }
  s.last = t;
  s.pending.reset();
  latest_ = t;
  ++accepted_;
  return t;
}

bool ObservationClock::believable(Sensor& sensor, double t) const
{
  const auto near = [t](const std::optional<double>& other)
  { return other && std::abs(t - *other) <= kLongestJump; };
  if (!latest_ || near(sensor.last) || near(latest_)) return true;
  const bool repeats = near(sensor.pending) && t >= *sensor.pending &&
                       sensor.accepted_then == accepted_ && t > *latest_;
  sensor.repeated = repeats ? sensor.repeated + 1 : 1;
  sensor.accepted_then = accepted_;
  sensor.pending = t;
  return sensor.repeated >= kRepetitions;
}

}  // namespace slalom::mrpt_io::detail
