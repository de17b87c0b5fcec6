// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <array>
#include <span>

#include "Surroundings.h"
#include "slalom/core/Vehicle.h"
#include "slalom/core/VelocityResponse.h"
#include "slalom/safety/OutputGate.h"

namespace slalom::safety::detail
{
/// The best way to stop that a command leaves.
struct Verdict
{
  double fixed = -std::numeric_limits<double>::infinity();  ///< [m] slack of the way to rest
  double mover = -std::numeric_limits<double>::infinity();  ///< [m] likewise, to what moves
  Cause cause = Cause::Map;                                 ///< of `fixed`
  const StopPath* plan = nullptr;  ///< null: straight away, or by the evasion
  Evasion evasion{};
  bool stands_clear = false;  ///< of all that stands
  bool leaves = true;         ///< does not end where something moves on to
  bool good = false;          ///< clear of all, as far as it is asked for

  [[nodiscard]] double slack() const { return std::min(fixed, mover); }
  [[nodiscard]] bool safe() const { return leaves && mover >= 0.0; }
  /// What stands never yields to what moves. Then, who runs ahead of somebody runs for ever:
  /// however little a way is clear that ends beside his way, it is the better one.
  [[nodiscard]] bool betterThan(const Verdict& other) const
  {
    if (stands_clear != other.stands_clear) return stands_clear;
    if (!stands_clear) return slack() > other.slack();
    return safe() != other.safe() ? safe() : mover > other.mover;
  }
};

/// Looks for ways to stop after a command, from one input of the gate.
class StopCheck
{
 public:
  /** @param last what the vehicle obeys until the command takes effect
   *  @param field null: nothing is known of what stands around */
  StopCheck(const GateInput& input, const SafetyConfig& config, const core::Vehicle& vehicle,
            const Eigen::Vector3d& last, const core::DistanceField* field);

  /// @param to_beat a verdict that is not better need not be exact
  /// @param aside the ways aside that may be counted on later
  [[nodiscard]] Verdict judge(const Eigen::Vector3d& command, const Verdict& to_beat,
                              std::span<const Evasion> aside) const;

  /// The same for a command from which the vehicle steps aside.
  [[nodiscard]] Verdict judge(const Eigen::Vector3d& command, const Evasion& evasion,
                              const Verdict& to_beat) const;

  /// Ways aside that are worth a look, the kept one first; none if stepping aside is not allowed.
  [[nodiscard]] std::span<const Evasion> evasions() const
  {
    return std::span(evasions_).first(evasion_count_);
  }
  /// What the last command counted on, if it did.
  [[nodiscard]] std::span<const Evasion> keptEvasion() const { return evasions().first(keeps_); }
  /// Whether the first of them is the one that the last command counted on.
  [[nodiscard]] bool keepsEvasion() const { return keeps_; }

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
  /// When a way need not be looked at any further.
  struct Enough
  {
    const Verdict& to_beat;
    double allowed;  ///< [m] slack of what stands that counts as clear
    [[nodiscard]] bool of(const Sweep& sweep) const;
  };
  /// @param from what the reserve of lag counts from; zero: without it
  void brakeToRest(Flight flight, const Eigen::Vector3d& from, const Enough& enough,
                   Sweep& sweep) const;
  void waitAtRest(Flight flight, const Enough& enough, Sweep& sweep) const;
  void followToRest(Flight flight, const StopPath& plan, const Piece& held, const Enough& enough,
                    Sweep& sweep) const;
  void evadeToRest(Flight flight, const Evasion& evasion, Eigen::Vector3d fastest,
                   const Enough& enough, Sweep& sweep) const;
  [[nodiscard]] Verdict brakeAfter(const Eigen::Vector3d& command, const Verdict& to_beat) const;
  [[nodiscard]] Verdict followAfter(const Eigen::Vector3d& command, const StopPath& plan,
                                    const Verdict& to_beat) const;
  void keepEvasion(const SafetyConfig& config);
  void listEvasions(const SafetyConfig& config);
  [[nodiscard]] bool stopsInRoom(const Flight& flight, double late, Sweep& sweep) const;
  [[nodiscard]] Eigen::Vector3d track(const StopPath& plan, const Flight& flight) const;
  [[nodiscard]] Eigen::Vector3d lateness(const Eigen::Vector3d& from,
                                         const Eigen::Vector3d& v) const;

  const GateInput& input_;
  const core::Vehicle& vehicle_;
  double lag_reserve_s_, graze_m_, evasion_margin_m_, hold_s_;
  double change_;  // [m/s] of the command per hold
  core::VelocityResponse response_;
  Flight begin_;
  Surroundings surroundings_;
  static constexpr std::size_t kMostEvasions = 25;
  std::array<Evasion, kMostEvasions> evasions_;
  std::size_t evasion_count_ = 0;
  bool keeps_ = false;
};

}  // namespace slalom::safety::detail
