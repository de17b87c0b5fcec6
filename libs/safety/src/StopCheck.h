// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

#include "Surroundings.h"
#include "slalom/core/Vehicle.h"
#include "slalom/core/VelocityResponse.h"
#include "slalom/safety/OutputGate.h"

namespace slalom::safety::detail
{
/// The best way to stop that a command leaves.
struct Verdict
{
  double slack = -std::numeric_limits<double>::infinity();  ///< [m] of the way to rest
  Cause cause = Cause::Map;
  const StopPath* plan = nullptr;  ///< null: straight away
  bool good = false;
};

/// Looks for ways to stop after a command, from one input of the gate.
class StopCheck
{
 public:
  /** @param last what the vehicle obeys until the command takes effect
   *  @param field null: nothing is known of what stands around */
  StopCheck(const GateInput& input, const SafetyConfig& config, const core::Vehicle& vehicle,
            const Eigen::Vector3d& last, const core::DistanceField* field);

  /// @param give_up_below a verdict below that need not be exact
  [[nodiscard]] Verdict judge(const Eigen::Vector3d& command, double give_up_below) const;

  /// The command with which the simulated vehicle starts to follow a plan, not yet limited.
  [[nodiscard]] Eigen::Vector3d follow(const StopPath& plan) const;

  /// The direction in which the map gives way where the command takes effect; 0 if unknown.
  [[nodiscard]] Eigen::Vector3d away() const { return surroundings_.away(); }

  /// [m] What a slack of 0 falls short of the radius; above 0 where the vehicle is too near
  /// already.
  [[nodiscard]] double excused() const { return surroundings_.excused(); }

  /// Where the command takes effect.
  struct Flight
  {
    Eigen::Vector3d p, v, u;  ///< [m], [m/s], [m/s] the command obeyed
    double tau = 0.0;         ///< [s] from now
  };
  [[nodiscard]] const Flight& begin() const { return begin_; }
  [[nodiscard]] double hold() const { return hold_s_; }
  /// [m/s^2] With commands that are held longer than a change may count over, less than the limit.
  [[nodiscard]] double deceleration() const { return change_ / hold_s_; }

 private:
  [[nodiscard]] Piece fly(Flight& flight, const Eigen::Vector3d& command) const;
  /// @param from what the reserve of lag counts from; zero: without it
  void brakeToRest(Flight flight, const Eigen::Vector3d& from, double give_up_below,
                   Sweep& sweep) const;
  void followToRest(Flight flight, const StopPath& plan, const Piece& held, double give_up_below,
                    Sweep& sweep) const;
  [[nodiscard]] bool stopsInRoom(const Flight& flight, double late, Sweep& sweep) const;
  [[nodiscard]] Eigen::Vector3d track(const StopPath& plan, const Flight& flight) const;
  [[nodiscard]] Eigen::Vector3d lateness(const Eigen::Vector3d& from,
                                         const Eigen::Vector3d& v) const;

  const GateInput& input_;
  const core::Vehicle& vehicle_;
  double lag_reserve_s_, graze_m_, hold_s_;
  double change_;  // [m/s] of the command per hold
  core::VelocityResponse response_;
  Flight begin_;
  Surroundings surroundings_;
};

}  // namespace slalom::safety::detail
