// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <deque>
#include <optional>

#include "slalom/core/Vehicle.h"
#include "slalom/core/VehicleState.h"
#include "slalom/core/VelocityResponse.h"

namespace slalom::engine
{
/** Knows where the vehicle will be when a command takes effect.
 *
 *  Keeps the commands of the last second. One that was sent at t is in effect from
 *  t + vehicle.command_delay_s until the next one is; in between the vehicle moves as
 *  core::held() says, plus a disturbance d: v' = (u - v) / lag + d. d is observed: low-passed, it
 * is the change of velocity that the commands do not explain (wind, a lag that is not the
 * configured one). Without a velocity lag the model leaves nothing to explain and d stays 0. While
 * nothing is known of the commands in effect the vehicle is taken to keep its velocity. */
class MotionPredictor
{
 public:
  explicit MotionPredictor(const core::Vehicle& vehicle) : vehicle_(vehicle) {}

  /// A command left at log time t [s]; calls in order of time.
  void sent(double t, const core::VelocityCommand& command);
  /// Learns from an estimate; one that is not newer than the last one is ignored.
  void observe(const core::VehicleState& state);
  /// The vehicle is not under these commands any more.
  void forget();

  /// When a command that is decided at t takes effect [s].
  [[nodiscard]] double effectOf(double t) const { return t + vehicle_.command_delay_s; }
  /// The command that the vehicle obeys at t [s]; zero while none is known.
  [[nodiscard]] core::VelocityCommand inEffect(double t) const;
  /** The state at time t [s]: `state` moved on under the commands in effect from state.t on.
   * `state` itself if it is not older than t. Attitude turns about the vertical only; the
   * covariance stays.
   */
  [[nodiscard]] core::VehicleState at(const core::VehicleState& state, double t) const;
  /// d [m/s^2], world axes; |d| <= 2.
  [[nodiscard]] const Eigen::Vector3d& disturbance() const { return disturbance_W_; }

 private:
  struct Sent
  {
    double effect_t;
    core::VelocityCommand command;
  };
  [[nodiscard]] core::Motion moved(core::Motion motion, double from, double to) const;

  core::Vehicle vehicle_;
  std::deque<Sent> sent_;
  std::optional<core::VehicleState> last_;
  Eigen::Vector3d disturbance_W_ = Eigen::Vector3d::Zero();
};

}  // namespace slalom::engine
