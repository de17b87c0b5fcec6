// SPDX-License-Identifier: BSD-3-Clause
#include "SensorWatch.h"

#include <cstdio>

namespace slalom::engine
{
namespace
{
std::string seconds(double value)
{
  char text[32];
  std::snprintf(text, sizeof text, "%.4g s", value);
  return text;
}
}  // namespace

void SensorWatch::heardScan(const std::string& label, double end_t)
{
  if (scan_t_ && end_t <= *scan_t_) return;
  interval_s_ = scan_t_ ? end_t - *scan_t_ : 0.0;
  scan_t_ = end_t;
  label_ = label.empty() ? "the range sensor" : label;
}

std::string SensorWatch::slowScans() const
{
  if (interval_s_ <= config_.safety.map_timeout_s) return {};
  return "scans of " + label_ + " come every " + seconds(interval_s_) +
         ", too slow for safety.map_timeout_s = " + seconds(config_.safety.map_timeout_s);
}

std::string SensorWatch::complaint(double t, const StateSource& source,
                                   std::optional<double> map_age_s) const
{
  if (source.deadReckoning()) return "neither position nor velocity (" + source.name() + ")";
  if (t - source.newest() > config_.safety.state_timeout_s)
    return "no state estimate (" + source.name() + ")";
  const double timeout = config_.safety.map_timeout_s;
  if (!map_age_s) return {};
  if (!scan_t_) return "no scan of any range sensor";
  constexpr double kMissed = 1.5;  // [1] of the usual interval
  std::string slow = slowScans();
  if (!slow.empty() && t - *scan_t_ < kMissed * interval_s_) return slow;
  if (t - *scan_t_ > timeout) return "no scan of " + label_;
  return *map_age_s > timeout ? "no map of the scans of " + label_ : std::string();
}

std::string SensorWatch::missing(double t, const StateSource& source,
                                 std::optional<double> map_age_s)
{
  const std::string what = complaint(t, source, map_age_s);
  if (what.empty())
    since_.reset();
  else if (!since_)
    since_ = t;
  if (!since_ || t - *since_ <= config_.mission.sensor_timeout_s) return {};
  return what + " for " + seconds(t - *since_) + ", longer than mission.sensor_timeout_s";
}

}  // namespace slalom::engine
