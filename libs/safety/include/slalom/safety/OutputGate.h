// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "slalom/core/DistanceField.h"
#include "slalom/core/MovingObstacle.h"
#include "slalom/core/Vehicle.h"
#include "slalom/core/VehicleState.h"
#include "slalom/safety/SafetyConfig.h"

namespace slalom::safety
{
/** A way to come to rest that someone planned: where the vehicle would be `begins_s + i * step_s`
 * seconds from now. Nothing of it is believed: the gate flies it in simulation and looks what is
 * hit. */
struct StopPath
{
  std::vector<Eigen::Vector3d> p_L;  ///< [m] local frame
  std::vector<Eigen::Vector3d> v_L;  ///< [m/s] as many; the last one is zero
  double step_s = 0.05;              ///< [s] > 0
  double begins_s = 0.0;  ///< [s] from now, of the first point; below 0 for a plan under way
};

/// A way aside: a velocity that is flown for a while, as far as the limits allow, then a brake.
struct Evasion
{
  Eigen::Vector3d v_W = Eigen::Vector3d::Zero();  ///< [m/s]
  double for_s = 0.0;  ///< [s] after the command was held; 0: there is none
};

/// Everything the gate may look at.
struct GateInput
{
  double t = 0.0;  ///< [s] log time, now
  /// The newest estimate, or the one predicted to the moment the command takes effect: state.t says
  /// which. From state.t to t + command_delay_s the vehicle is taken to obey `last`.
  core::VehicleState state;
  double state_age_s = 0.0;  ///< [s] of the measurement behind `state`
  double map_age_s = 0.0;    ///< [s]
  double plan_age_s = std::numeric_limits<double>::infinity();  ///< [s] infinity: there is none
  bool needs_map = true;  ///< false: the host flies without a map on purpose; the ages of map and
                          ///< plan do not count then
  std::shared_ptr<const core::DistanceField> field;  ///< may be null
  std::span<const core::MovingObstacle> movers;
  core::VelocityCommand wanted;
  core::VelocityCommand last;      ///< what left the gate before
  double dt = 0.05;                ///< [s] since then
  double hold_s = 0.0;             ///< [s] how long the command will be held, if longer than dt
  const StopPath* plan = nullptr;  ///< of the newest plan, may be null
  /// The plan that the last command relied on, if it is another one (GateOutput::stop_plan), as
  /// seen from now; may be null.
  const StopPath* kept_plan = nullptr;
  Evasion kept_evasion;   ///< GateOutput::evasion of the last pass
  bool may_evade = true;  ///< false: the vehicle is not to move by itself, as without a mission
};

/// Why the command is not the one that was wanted.
enum class Intervention
{
  None,
  NotFinite,  ///< a number of the command or of the state is not finite, or absurd
  Limits,     ///< speed, acceleration, yaw rate
  StateTooOld,
  MapTooOld,   ///< or there is none
  PlanTooOld,  ///< or there is none
  Geofence,
  NoStop,         ///< the wanted command would have lost the last way to stop
  MovingObstacle  ///< the same because of a moving obstacle
};
[[nodiscard]] std::string_view toString(Intervention intervention);

struct GateOutput
{
  core::VelocityCommand command;  ///< finite and inside all limits
  Intervention intervention = Intervention::None;
  /// [m] proved clearance beyond the radius of the stop that is still possible after the command;
  /// below 0 if no stop keeps the radius. 0 where it was not looked for.
  double stop_margin_m = 0.0;
  /// The plan of the input along which the vehicle can stop; null: by braking straight away, or
  /// not known. Keep it, and hand it in as kept_plan next time.
  const StopPath* stop_plan = nullptr;
  Evasion evasion;     ///< by which the vehicle stays clear of what moves. Hand it in next time.
  std::string reason;  ///< one line; empty without intervention
};

/** The last thing that a velocity command passes; it trusts no planner.
 *
 *  Whatever the bits of the input, the command is finite, inside the speed limit per axis and the
 *  yaw rate limit, and per axis not farther from `last` than max_acceleration_mps2 * dt (dt counts
 *  as 0 if negative or not a number, as 0.2 s if longer; a `last` that is not finite is replaced by
 *  the measured velocity, else by 0, and one outside the limits by the nearest inside).
 *
 *  With verify_stop it also keeps this true: after the command was held a stop inside known free
 *  space still exists, either by braking as hard as the limits permit or by following a planned
 *  StopPath. The whole way is looked at, with the velocity lag of the vehicle. Clear means that the
 *  radius is kept, or where the vehicle is already nearer, that it comes no nearer than it is. If
 *  the wanted command has no such stop, a milder one between it and the brake, the brake, or the
 *  first command along a plan is passed; if none of these has one, the one with the largest least
 *  clearance.
 *
 *  Moving obstacles are to stay clear of that way as far as they are predicted. Where they would
 *  not, a way aside counts, too: flown for a while and then braked to rest, all of it inside known
 *  free space. If the wanted command leaves none with a margin, the way aside that keeps the
 *  largest distance is begun at once. What stands never yields to what moves: of several ways those
 * clear of the map come first.
 *
 *  Braking for lack of trust (ages, numbers) goes along a plan where braking straight away would
 *  hit something and the plan does not. Only with a state that is too old the brake is blind.
 *
 *  Pure, thread-safe, deterministic. No allocation but for the reason. */
class OutputGate
{
 public:
  /// @throws std::invalid_argument on a field outside its range or a fence without inside
  OutputGate(const SafetyConfig& config, const core::Vehicle& vehicle);

  [[nodiscard]] GateOutput pass(const GateInput& input) const;

 private:
  SafetyConfig config_;
  core::Vehicle vehicle_;
};

}  // namespace slalom::safety
