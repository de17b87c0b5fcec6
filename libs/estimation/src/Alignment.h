// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <deque>
#include <optional>
#include <vector>

#include "FilterState.h"
#include "Prediction.h"
#include "Update.h"

namespace slalom::estimation::detail
{
/// Is the IMU fast enough to be integrated? Judged over the last second, with hysteresis.
class ImuGauge
{
 public:
  explicit ImuGauge(const FilterConfig& config) : config_(config) {}
  void add(double t);
  [[nodiscard]] bool adequate() const { return adequate_; }

 private:
  FilterConfig config_;
  std::deque<double> times_;
  bool adequate_ = false;
};

/** "Up" in the body at time t, as a Gravity aid: mean specific force of the samples around t, each
 * turned into the body axes of t by the gyroscope. Its standard deviation tells rest from flight (a
 * multi-rotor's force points along its mast whatever the tilt, so flight gets a wide one). nullopt
 * without samples within half a second. */
[[nodiscard]] std::optional<Aid> gravityAt(double t, const std::deque<RatedImu>& samples);

/// The moment from which the filter runs.
struct Start
{
  FilterState state;  ///< heading zero unless heading_known
  bool heading_known = false;
  std::optional<RatedImu> before;  ///< newest IMU sample at or before the start
  std::vector<RatedImu> imu;       ///< what has been heard since, in order
  std::vector<Aid> aids;
};

/** Collects measurements until tilt and position are known: half a second of adequate IMU and a
 * position or pose; or, when a second passes without an adequate IMU, the position alone. */
class Alignment
{
 public:
  Alignment(const FilterConfig& config, bool has_gravity = false)
      : config_(config), has_gravity_(has_gravity)
  {
  }
  void add(const RatedImu& imu, bool adequate);
  void add(const Aid& aid);
  [[nodiscard]] bool hasGravity() const { return has_gravity_; }
  [[nodiscard]] std::optional<Start> tryStart() const;

 private:
  [[nodiscard]] Start startAt(const Aid& fix, bool inertial) const;
  void trim();

  FilterConfig config_;
  bool has_gravity_;
  std::deque<RatedImu> imu_;
  std::deque<Aid> aids_;
  std::optional<double> first_;
  double newest_ = kNever;
};

}  // namespace slalom::estimation::detail
