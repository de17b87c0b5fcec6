// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace slalom::report
{
/** Value below which the share `q` of the samples lies, by linear interpolation between order
 * statistics at rank q (n-1), counted from 0 (type 7 of Hyndman and Fan, 1996).
 *  @param q in [0, 1]; nullopt when there are no samples */
[[nodiscard]] std::optional<double> quantile(std::vector<double> samples, double q);

/// Summary of a sample; all nullopt when n = 0. Non-finite samples are left out.
struct Distribution
{
  std::uint64_t n = 0;
  std::optional<double> mean, median, p95, p99, max;
};
[[nodiscard]] Distribution describe(const std::vector<double>& samples);

/// Wall time of the parts of a cycle [s], over the cycles in which the part ran.
struct TimingMetrics
{
  Distribution estimate, map, edt, global, local, cycle;
  std::uint64_t map_misses = 0, global_misses = 0, local_misses = 0;  ///< cycles over the deadline
};

/// What the global and the local planner did.
struct PlanningMetrics
{
  std::uint64_t replans = 0;  ///< cycles with a global step
  std::uint64_t refined_ok = 0, refined_failed = 0, recoveries = 0;
  std::uint64_t certified = 0;  ///< plans proved clear over their whole length
  std::uint64_t rescues = 0;    ///< plans that must brake harder than planned to rest in time
  double time_without_verified_stop_s = 0.0;
  std::uint64_t shifted = 0, backup = 0, brake = 0;  ///< cycles commanded by a fallback
};

struct SafetyMetrics
{
  std::map<std::string, std::uint64_t> gate;    ///< cycles in which the output gate changed the
                                                ///< command, by reason
  std::map<std::string, std::uint64_t> events;  ///< by name
  std::uint64_t most_movers = 0;                ///< tracked at once
};

/// The numbers of a flight that follow from its cycle records.
struct FlightMetrics
{
  std::uint64_t cycles = 0;
  double duration_s = 0.0;  ///< last cycle minus first
  double length_m = 0.0;    ///< sum of the steps between cycles (estimate)
  std::optional<double> reference_length_m, goal_error_m;
  std::optional<double> min_map_clearance_m;  ///< vehicle centre to the nearest known obstacle
  double time_below_hard_s = 0.0;
  Distribution vs_reference_m;    ///< position against R at the same cycle's progress
  Distribution vs_setpoint_m;     ///< position at the moment a setpoint was meant for, against it
  Distribution estimate_error_m;  ///< estimate against truth, world frame, both at estimate time
  std::optional<double> mean_speed_mps, max_speed_mps, max_acceleration_mps2;
  TimingMetrics timing;
  PlanningMetrics planning;
  SafetyMetrics safety;
  std::string decision_hash;  ///< 16 hex digits; empty before the first cycle
};

}  // namespace slalom::report
