// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>

#include "slalom/core/Fields.h"
#include "slalom/core/VehicleState.h"
#include "slalom/simulation/Motion.h"

namespace slalom::simulation
{
enum class AirframeModel
{
  Lag,       ///< SimulatedVehicle.h
  Quadrotor  ///< Quadrotor.h
};

/// How the simulated vehicle really answers to commands. What the tracker believes of it is
/// [vehicle]. INI section [airframe].
struct AirframeConfig
{
  AirframeModel model = AirframeModel::Quadrotor;
  double velocity_lag_s = 0.2;         ///< [s] with which the velocity follows the command
  double yaw_rate_lag_s = 0.1;         ///< [s] time constant of the yaw rate
  double command_delay_s = 0.02;       ///< [s] until it begins to obey
  double max_acceleration_mps2 = 6.0;  ///< [m/s^2] in any direction
  double max_yaw_rate_radps = 2.0;     ///< [rad/s]
  double attitude_lag_s = 0.08;        ///< [s] with which the tilt follows the acceleration
  double drag_per_s = 0.25;            ///< [1/s] acceleration per speed of the wind
  Eigen::Vector3d wind_mps = Eigen::Vector3d::Zero();  ///< [m/s] where the air moves to, world axes
  // Of the quadrotor alone:
  double gust_mps = 0.0;             ///< [m/s] sigma per horizontal axis, half of it vertically
  double gust_time_s = 1.5;          ///< [s] correlation time
  double rotor_lag_s = 0.03;         ///< [s] with which the thrust follows
  double max_tilt_deg = 40.0;        ///< [deg] from the vertical
  double min_thrust_g = 0.2;         ///< [1] least thrust, in weights
  double max_thrust_g = 2.0;         ///< [1] greatest thrust, in weights
  double velocity_damping = 0.2;     ///< [1] acceleration fed back, per acceleration
  double velocity_integral = 1.0;    ///< [1/s^2] acceleration per metre of velocity error
  double max_integral_mps2 = 3.0;    ///< [m/s^2]
  double max_body_rate_radps = 6.0;  ///< [rad/s] roll and pitch

  template <class Self, class Visit>
  static void fields(Self& c, Visit&& v)
  {
    using core::Level;
    using core::Range;
    v("model", c.model,
      core::Names<AirframeModel>{{"lag", AirframeModel::Lag},
                                 {"quadrotor", AirframeModel::Quadrotor}},
      "lag: the velocity follows the command with a lag; quadrotor: a rigid body under a cascaded "
      "velocity and attitude autopilot");
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
    v("gust_mps", c.gust_mps, Range{0.0, 20.0},
      "sigma of the gusts, per horizontal axis, half of it vertically (quadrotor)");
    v("gust_time_s", c.gust_time_s, Range{0.05, 100.0}, "correlation time of the gusts");
    v("rotor_lag_s", c.rotor_lag_s, Range{0.0, 1.0}, "time constant of the thrust (quadrotor)",
      Level::Expert);
    v("max_tilt_deg", c.max_tilt_deg, Range{5.0, 75.0}, "tilt limit (quadrotor)", Level::Expert);
    v("min_thrust_g", c.min_thrust_g, Range{0.0, 0.9}, "least thrust, in weights (quadrotor)",
      Level::Expert);
    v("max_thrust_g", c.max_thrust_g, Range{1.1, 10.0}, "greatest thrust, in weights (quadrotor)",
      Level::Expert);
    v("velocity_damping", c.velocity_damping, Range{0.0, 2.0},
      "feedback of the acceleration in the velocity loop (quadrotor)", Level::Expert);
    v("velocity_integral", c.velocity_integral, Range{0.0, 10.0},
      "integral gain of the velocity loop, 1/s^2 (quadrotor)", Level::Expert);
    v("max_integral_mps2", c.max_integral_mps2, Range{0.0, 20.0},
      "limit of the integral part (quadrotor)", Level::Expert);
    v("max_body_rate_radps", c.max_body_rate_radps, Range{0.5, 30.0},
      "limit of roll and pitch rates (quadrotor)", Level::Expert);
  }
};

/// A vehicle that obeys velocity commands in its own time. Not thread-safe.
class VehicleModel
{
 public:
  virtual ~VehicleModel() = default;
  /// To be obeyed from now + command_delay on, until another one. @throws std::invalid_argument
  virtual void command(const core::VelocityCommand& command) = 0;
  virtual void advance(double dt) = 0;            ///< [s] >= 0
  [[nodiscard]] virtual double time() const = 0;  ///< [s] since construction
  /// The whole state; acceleration and body rate are the means of the last advance().
  [[nodiscard]] virtual const MotionSample& sample() const = 0;
};

/** The model that the config asks for, at rest at p_W.
 *  @param seed of the gusts
 *  @throws std::invalid_argument if the start is not finite, or the model cannot do what is asked
 */
[[nodiscard]] std::unique_ptr<VehicleModel> makeVehicle(const AirframeConfig& config,
                                                        const Eigen::Vector3d& p_W, double yaw,
                                                        std::uint64_t seed);

}  // namespace slalom::simulation
