// SPDX-License-Identifier: BSD-3-Clause
/** What the caller knows about a run and the report cannot see in the cycle records. Plain values;
 * an absent optional becomes null in metrics.json. */
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>

namespace slalom::report
{
/// Known before the first cycle.
struct RunInfo
{
  std::string title = "Slalom flight";  ///< of the pictures, e.g. the name of the recording
  double epoch_s = 0.0;                 ///< [s] Unix time of log time 0; TUM stamps are epoch + t
  double vehicle_radius_m = 0.35;
  double hard_clearance_m = 0.35;   ///< [m] centre to obstacle; below it is a violation
  double wanted_clearance_m = 0.8;  ///< [m] D_z, kept where the gap permits
  double max_speed_mps = 0.0;       ///< [m/s] drawn as a limit; 0 = not drawn
  double setpoint_lead_s = 0.1;     ///< [s] CycleRecord::setpoint_L is meant for t + this
  double map_deadline_s = 0.0;      ///< [s] map + EDT of one cycle; 0 = no deadline
  double global_deadline_s = 0.0;   ///< [s]
  double local_deadline_s = 0.0;    ///< [s]
  std::string effective_ini;        ///< text of effective.ini; empty = no such file

  std::string version, build, method = "slalom", config_sha256;
  std::optional<std::uint64_t> seed;
  int threads = 1;
  std::string rawlog, rawlog_sha256;  ///< empty: not a replay
};

/// How the run ended. `name` is one of GOAL_REACHED, GOAL_BLOCKED, TIMEOUT, COLLISION, ...
struct RunResult
{
  int code = 1;  ///< exit code of the program
  std::string name = "INTERNAL_ERROR";
  std::string message;
  bool success = false;  ///< reached the goal, no collision, no limit violated
};

/// What came in.
struct InputSummary
{
  std::optional<double> duration_s;
  std::map<std::string, std::uint64_t> observations;  ///< class -> count
  std::optional<double> points_per_scan_median, points_per_scan_max;
  std::map<std::string, std::uint64_t> dropped;  ///< reason -> count
};

/// A simulated flight as it really was, whatever the estimate says.
struct TrueFlight
{
  double duration_s = 0.0, length_m = 0.0;                  ///< until the end of the mission
  double straight_m = 0.0;                                  ///< from start to goal
  double goal_distance_m = 0.0;                             ///< when it ended
  double max_speed_mps = 0.0, max_acceleration_mps2 = 0.0;  ///< norms
  std::uint64_t contacts = 0;
  std::optional<double> shortest_m;            ///< shortest way there, if all were known
  std::optional<double> stop_error_m;          ///< blocked: to where it should have stopped
  std::optional<double> clearance_p05_m;       ///< nearer than this for 5 % of the time
  std::optional<double> min_mover_distance_m;  ///< centre to surface; absent without movers
  double acceleration_effort_m2_s3 = 0.0;      ///< integral of the squared acceleration
  double jerk_effort_m2_s5 = 0.0;              ///< likewise of the jerk
};

/// Known after the last cycle.
struct RunSummary
{
  RunResult result;
  InputSummary input;
  std::optional<double> goal_error_m;  ///< from the truth; absent: of the last cycle's estimate
  std::optional<double> min_true_clearance_m;  ///< from the world's geometry; absent in replay
  std::optional<double> realtime_factor;
  std::optional<TrueFlight> flight;  ///< of a simulated flight only
};

}  // namespace slalom::report
