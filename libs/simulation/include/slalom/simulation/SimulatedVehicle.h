// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <deque>

#include "slalom/core/Fields.h"
#include "slalom/core/VelocityResponse.h"
#include "slalom/simulation/Motion.h"

namespace slalom::simulation
{
/// How the simulated vehicle really answers to commands. What the tracker believes of it is
/// [vehicle]. INI section [airframe].
struct AirframeConfig
{
  double velocity_lag_s = 0.2;         ///< [s] time constant of the velocity
  double yaw_rate_lag_s = 0.1;         ///< [s] time constant of the yaw rate
  double command_delay_s = 0.02;       ///< [s] until it begins to obey
  double max_acceleration_mps2 = 6.0;  ///< [m/s^2] in any direction
  double max_yaw_rate_radps = 2.0;     ///< [rad/s]
  double attitude_lag_s = 0.08;        ///< [s] with which the tilt follows the acceleration
  double drag_per_s = 0.25;            ///< [1/s] acceleration per speed of the wind
  Eigen::Vector3d wind_mps = Eigen::Vector3d::Zero();  ///< [m/s] where the air moves to, world axes

  template <class Self, class Visit>
  static void fields(Self& c, Visit&& v)
  {
    using core::Range;
    v("velocity_lag_s", c.velocity_lag_s, Range{0.01, 5.0},
      "time constant with which the velocity follows the command");
    v("yaw_rate_lag_s", c.yaw_rate_lag_s, Range{0.0, 5.0},
      "time constant with which the yaw rate follows the command; 0 = at once");
    v("command_delay_s", c.command_delay_s, Range{0.0, 2.0},
      "from the arrival of a command until the vehicle begins to obey it");
    v("max_acceleration_mps2", c.max_acceleration_mps2, Range{0.1, 50.0},
      "largest acceleration, in any direction");
    v("max_yaw_rate_radps", c.max_yaw_rate_radps, Range{0.05, 20.0}, "yaw rate limit");
    v("attitude_lag_s", c.attitude_lag_s, Range{0.0, 1.0},
      "time constant with which the tilt follows the acceleration");
    v("drag_per_s", c.drag_per_s, Range{0.0, 10.0},
      "acceleration that a wind of 1 m/s causes before the autopilot counters it");
    v("wind_mps", c.wind_mps, "x,y,z of a constant wind, where the air moves to");
  }
};

/** A multirotor under a velocity autopilot:
 *
 *    v' = (u - v) / lag + drag wind, |v'| <= max_acceleration,   p' = v,   likewise the yaw rate
 *
 *  with the command u of command_delay ago. Solved in closed form between two commands, so that the
 * result does not depend on the size of the steps. The body tilts towards a_W + g e_z, smoothed by
 * attitude_lag. */
class SimulatedVehicle
{
 public:
  /// At rest at p_W. @throws std::invalid_argument if that is not finite
  SimulatedVehicle(const AirframeConfig& config, const Eigen::Vector3d& p_W, double yaw);

  /// To be obeyed from now + command_delay on, until another one. @throws std::invalid_argument
  void command(const core::VelocityCommand& command);
  void advance(double dt);  ///< [s] >= 0

  [[nodiscard]] double time() const { return t_; }  ///< [s] since construction
  [[nodiscard]] const core::Motion& motion() const { return motion_; }
  /// The whole state; acceleration and body rate are the means of the last step.
  [[nodiscard]] const MotionSample& sample() const { return sample_; }

 private:
  struct Waiting
  {
    double t;
    core::VelocityCommand command;
  };
  void obey(double dt);
  [[nodiscard]] Eigen::Vector3d wanted() const;

  AirframeConfig config_;
  double t_ = 0.0;
  core::Motion motion_;
  core::VelocityCommand obeyed_;
  std::deque<Waiting> waiting_;
  Eigen::Vector3d tilt_W_ = Eigen::Vector3d::Zero();  // [m/s^2] acceleration that the tilt shows
  MotionSample sample_;
};

}  // namespace slalom::simulation
