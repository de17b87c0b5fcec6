// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "slalom/core/Measurements.h"
#include "slalom/core/VehicleState.h"
#include "slalom/engine/EngineConfig.h"
#include "slalom/estimation/StateEstimator.h"

namespace slalom::engine
{
/// Decides where the state comes from and answers for it. Measurements of other sources are
/// ignored.
class StateSource
{
 public:
  StateSource(const StateConfig& config, const estimation::FilterConfig& filter);

  /// Range scans are not for this room and ignored.
  void add(const core::Measurement& measurement);

  [[nodiscard]] std::optional<core::VehicleState> state(
      double t) const;  ///< newest, moved to t if near enough
  [[nodiscard]] std::optional<core::VehicleState> stateAt(double t) const;  ///< of the recent past
  [[nodiscard]] double newest() const
  {
    return newest_;
  }  ///< [s] up to here stateAt() does not extrapolate
  [[nodiscard]] StateSourceKind kind() const { return kind_; }
  /// True when nothing but silence made the vehicle stand still: good enough for a map, never for a
  /// mission.
  [[nodiscard]] bool onlyAssumed() const
  {
    return kind_ == StateSourceKind::Static && config_.source == StateSourceKind::Auto;
  }
  /// Neither position nor velocity for longer than the filter's time-out.
  [[nodiscard]] bool deadReckoning() const
  {
    return estimator_.status() == estimation::EstimatorStatus::DeadReckoning;
  }
  /// Counts the times the local frame had to begin anew: maps and plans made before are void.
  [[nodiscard]] std::uint64_t frameEpoch() const { return frame_epoch_; }
  [[nodiscard]] std::string name() const;
  [[nodiscard]] const estimation::EstimatorCounters& counters() const
  {
    return estimator_.counters();
  }

 private:
  void decide(const core::Measurement& measurement);
  void feed(const core::Measurement& measurement);
  void followFrame(const core::VehicleState& state);
  [[nodiscard]] std::optional<core::VehicleState> placed(
      std::optional<core::VehicleState> state) const;

  StateConfig config_;
  estimation::StateEstimator estimator_;
  StateSourceKind kind_;
  std::optional<double> first_;               // time of the first measurement of any kind
  std::vector<core::Measurement> undecided_;  // Auto: kept until the source is known
  double newest_ = 0.0;
  std::optional<core::VehicleState> last_;  // of the filter, as it came
  bool was_assumed_ = false;
  std::uint64_t frame_epoch_ = 0;
  std::optional<Eigen::Vector3d> origin_L_;  // added to the filter's local positions: L begins as W
};

}  // namespace slalom::engine
