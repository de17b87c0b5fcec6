// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include "slalom/core/Measurements.h"
#include "slalom/core/VehicleState.h"
#include "slalom/estimation/FilterConfig.h"

namespace slalom::estimation
{
enum class EstimatorStatus
{
  Waiting,   ///< nothing usable yet
  Aligning,  ///< gravity known, position or heading still missing
  Running,
  DeadReckoning  ///< running, but no position or velocity for longer than the time-out
};

/// Counters that end up in metrics.json.
struct EstimatorCounters
{
  std::uint64_t imu = 0, position = 0, velocity = 0, yaw = 0, pose = 0;
  std::map<std::string, std::uint64_t>
      dropped;               ///< reason -> count (gated, too old, non-finite, ...)
  std::uint64_t resets = 0;  ///< re-initialisations after a run of rejects
};

/** Error-state Kalman filter on IMU, GPS, velocity and heading: 15 states (position, velocity,
 * rotation, gyroscope and accelerometer bias). Predicts at IMU rate (or with a constant-velocity
 * model when there is no usable IMU); Joseph updates; chi-square gates with a re-initialisation
 * rule; measurements that arrive late are applied at their own time by replaying a ring buffer of
 * IMU samples. Aligns itself: tilt from gravity at rest, heading from velocity/course or a yaw
 * source.
 *
 *  Besides the world position it integrates the smooth local one (VehicleState::p_L): moved by
 * velocity only, never by a position correction. Calls must be made in order of arrival; time
 * stamps may lag by config.max_delay_s. Not thread-safe; deterministic. @see algorithm in
 * docs/paper_map.md, deviation D-09 */
class StateEstimator
{
 public:
  explicit StateEstimator(const FilterConfig& config);
  ~StateEstimator();
  StateEstimator(StateEstimator&&) noexcept;
  StateEstimator& operator=(StateEstimator&&) noexcept;

  void add(const core::ImuSample& sample);
  void add(const core::PositionFix& fix);
  void add(const core::VelocityFix& fix);
  void add(const core::YawFix& fix);
  void add(const core::PoseFix& fix);

  [[nodiscard]] EstimatorStatus status() const;

  /// Newest state; nullopt until Running.
  [[nodiscard]] std::optional<core::VehicleState> state() const;

  /** State at time t: interpolated in the buffer of the recent past, extrapolated with constant
   * velocity and rate by at most config.max_extrapolation_s. nullopt outside. Used for motion
   * compensation and for prediction. */
  [[nodiscard]] std::optional<core::VehicleState> stateAt(double t) const;

  [[nodiscard]] const EstimatorCounters& counters() const;
  void reset();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace slalom::estimation
