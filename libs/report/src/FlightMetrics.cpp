// SPDX-License-Identifier: BSD-3-Clause
#include "slalom/report/FlightMetrics.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <numeric>

#include "FlightLog.h"

namespace slalom::report
{
namespace
{
double sortedQuantile(const std::vector<double>& sorted, double q)
{
  const double rank = std::clamp(q, 0.0, 1.0) * static_cast<double>(sorted.size() - 1);
  const auto below = static_cast<std::size_t>(rank);
  const std::size_t above = std::min(below + 1, sorted.size() - 1);
  const double share = rank - static_cast<double>(below);
  return sorted[below] + share * (sorted[above] - sorted[below]);
}
}  // namespace

std::optional<double> quantile(std::vector<double> samples, double q)
{
  if (samples.empty()) return std::nullopt;
  std::sort(samples.begin(), samples.end());
  return sortedQuantile(samples, q);
}

Distribution describe(const std::vector<double>& samples)
{
  std::vector<double> finite;
  finite.reserve(samples.size());
  std::copy_if(samples.begin(), samples.end(), std::back_inserter(finite),
               [](double x) { return std::isfinite(x); });
  Distribution d;
  d.n = finite.size();
  if (finite.empty()) return d;
  std::sort(finite.begin(), finite.end());
  d.mean = std::accumulate(finite.begin(), finite.end(), 0.0) / static_cast<double>(finite.size());
  d.median = sortedQuantile(finite, 0.5);
  d.p95 = sortedQuantile(finite, 0.95);
  d.p99 = sortedQuantile(finite, 0.99);
  d.max = finite.back();
  return d;
}

namespace detail
{
namespace
{
template <class Get>
std::vector<double> column(const std::vector<CycleSummary>& cycles, Get get)
{
  std::vector<double> values;
  values.reserve(cycles.size());
  for (const CycleSummary& cycle : cycles) values.push_back(get(cycle));
  return values;
}

/// Cycles in which the part ran.
Distribution timeOf(const std::vector<CycleSummary>& cycles, double core::CycleTiming::*part)
{
  std::vector<double> values;
  for (const CycleSummary& cycle : cycles)
    if (cycle.timing.*part > 0.0) values.push_back(cycle.timing.*part);
  return describe(values);
}

TimingMetrics timingOf(const std::vector<CycleSummary>& cycles, const RunInfo& info)
{
  using core::CycleTiming;
  TimingMetrics m;
  m.estimate = timeOf(cycles, &CycleTiming::estimate);
  m.map = timeOf(cycles, &CycleTiming::map);
  m.edt = timeOf(cycles, &CycleTiming::edt);
  m.global = timeOf(cycles, &CycleTiming::global);
  m.local = timeOf(cycles, &CycleTiming::local);
  m.cycle = timeOf(cycles, &CycleTiming::cycle);
  const auto missed = [](double spent, double deadline)
  { return deadline > 0.0 && spent > deadline; };
  for (const CycleSummary& cycle : cycles)
  {
    m.map_misses += missed(cycle.timing.map + cycle.timing.edt, info.map_deadline_s);
    m.global_misses += missed(cycle.timing.global, info.global_deadline_s);
    m.local_misses += missed(cycle.timing.local, info.local_deadline_s);
  }
  return m;
}
}  // namespace

FlightMetrics computeMetrics(const std::vector<CycleSummary>& cycles, const RunInfo& info)
{
  FlightMetrics m;
  m.cycles = cycles.size();
  if (cycles.empty()) return m;
  m.duration_s = cycles.back().t - cycles.front().t;
  m.vs_reference_m = describe(column(cycles, [](const auto& c) { return c.vs_reference_m; }));
  m.vs_setpoint_m = describe(column(cycles, [](const auto& c) { return c.vs_setpoint_m; }));
  m.estimate_error_m = describe(column(cycles, [](const auto& c) { return c.estimate_error_m; }));
  const Distribution speed = describe(column(cycles, [](const auto& c) { return c.speed_mps; }));
  m.mean_speed_mps = speed.mean;
  m.max_speed_mps = speed.max;
  m.timing = timingOf(cycles, info);

  double nearest = kNone;
  for (std::size_t i = 0; i < cycles.size(); ++i)
  {
    nearest = std::fmin(nearest, cycles[i].clearance_m);
    if (i > 0 && cycles[i].clearance_m < info.hard_clearance_m)
      m.time_below_hard_s += cycles[i].t - cycles[i - 1].t;
  }
  if (std::isfinite(nearest)) m.min_map_clearance_m = nearest;
  return m;
}

std::string hexOf(std::uint64_t value)
{
  std::array<char, 16> digits{};
  const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), value, 16);
  const std::string text(digits.data(), end.ptr);
  return std::string(16 - text.size(), '0') + text;
}
}  // namespace detail

}  // namespace slalom::report
