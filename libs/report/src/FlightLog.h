// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <deque>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "slalom/core/CycleRecord.h"
#include "slalom/report/FlightMetrics.h"
#include "slalom/report/RunInfo.h"

namespace slalom::report::detail
{
inline constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

enum class FallbackKind : std::uint8_t
{
  None,
  Shifted,
  Backup,
  Brake,
  Other
};

/// What is remembered of a cycle. NaN = not there, p_L too before the first estimate. Fixed size:
/// no strings, no pointers.
struct CycleSummary
{
  double t = 0.0;                                          ///< [s] log time
  Eigen::Vector3d p_L = Eigen::Vector3d::Constant(kNone);  ///< [m] estimate
  Eigen::Vector3d refined_L = Eigen::Vector3d::Constant(kNone);
  double reference_z = kNone;  ///< [m]
  double detour_m = kNone;     ///< |refined - R| at the progress
  double vs_reference_m = kNone, vs_setpoint_m = kNone, estimate_error_m = kNone;
  double speed_mps = kNone, commanded_speed_mps = 0.0;
  double clearance_m = kNone;
  core::CycleTiming timing;
  FallbackKind fallback = FallbackKind::None;
};
static_assert(sizeof(CycleSummary) <= 200, "a flight of an hour at 20 Hz must stay below 15 MB");

/** Folds cycle records and truth into summaries and running counts. */
class FlightLog
{
 public:
  explicit FlightLog(const RunInfo& info) : info_(info) {}

  const CycleSummary& add(const core::CycleRecord& record);
  void addTruth(double t, const Eigen::Vector3d& p_W);

  [[nodiscard]] const std::vector<CycleSummary>& cycles() const { return cycles_; }
  /// Truth in the local frame, thinned to one point per decimetre.
  [[nodiscard]] const std::vector<Eigen::Vector3d>& truthPath() const { return truth_path_L_; }
  /// R of the newest cycle that had one.
  [[nodiscard]] const core::Polyline& reference() const { return reference_L_; }
  [[nodiscard]] FlightMetrics metrics() const;
  [[nodiscard]] std::size_t memoryBytes() const;

 private:
  struct Timed
  {
    double t;
    Eigen::Vector3d p;
    std::size_t cycle = 0;
    Eigen::Vector3d offset = Eigen::Vector3d::Zero();  ///< p_L - p_W then
  };
  void addMotion(const core::CycleRecord& record, CycleSummary& now);
  void addMission(const core::CycleRecord& record, CycleSummary& now);
  void countPlanning(const core::CycleRecord& record);
  void matchSetpoints();
  void matchTruth();

  RunInfo info_;
  std::vector<CycleSummary> cycles_;
  std::deque<Timed> open_setpoints_;  ///< not yet flown past
  std::deque<Timed> open_estimates_;  ///< waiting for truth
  std::deque<Timed> truth_;           ///< that estimates may still need
  std::vector<Eigen::Vector3d> truth_path_L_;
  core::Polyline reference_L_;
  Eigen::Vector3d last_velocity_W_ = Eigen::Vector3d::Zero();
  double distance_to_goal_m_ = kNone;
  double max_acceleration_mps2_ = kNone;
  double length_m_ = 0.0;
  PlanningMetrics planning_;
  SafetyMetrics safety_;
  std::uint64_t decision_hash_ = 0;
};

/// The part of the metrics that follows from the summaries alone.
[[nodiscard]] FlightMetrics computeMetrics(const std::vector<CycleSummary>& cycles,
                                           const RunInfo& info);
/// 16 lower-case hex digits.
[[nodiscard]] std::string hexOf(std::uint64_t value);
[[nodiscard]] FallbackKind fallbackKind(std::string_view name);
[[nodiscard]] double lengthOf(const core::Polyline& line);
/// Distance from the vehicle's centre to the nearest known obstacle [m]; NaN without a field.
[[nodiscard]] double clearanceOf(const core::CycleRecord& record);

}  // namespace slalom::report::detail
