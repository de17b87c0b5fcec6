// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <deque>

#include "slalom/core/Rng.h"
#include "slalom/simulation/Airframe.h"

namespace slalom::simulation
{
/** A rigid body with one thrust along its z axis, under a cascaded autopilot:
 *
 *    p' = v,  v' = f z_B - g e_z - drag (v - wind - gust)              per unit of mass
 *    a_set = ((1 + damping) / lag) (u - v) - damping v' + integral     |a_set| <= max_acceleration
 *    f' = (a_set + g e_z) . z_B - f, / rotor_lag                       min_thrust <= f <=
 * max_thrust roll and pitch: z_B turns to a_set + g e_z as a critically damped second order, both
 * time constants half of attitude_lag; the direction is no further from the vertical than max_tilt
 *    yaw: follows the heading of a vehicle whose rate has the lag yaw_rate_lag
 *
 *  with the command u of command_delay ago. The integral part is held while a limit binds. In still
 * air, limits apart and without integral and drag, the area between a step of the command and the
 * velocity is lag times the step, whatever the inner loops do. Gusts are coloured noise of first
 * order (as Dryden's along the wind). Integrated with a fixed inner step: equal for every division
 * of time into advances. Vertical demands go before horizontal ones. */
class Quadrotor : public VehicleModel
{
 public:
  static constexpr double kStep = 1e-3;  ///< [s]

  /// At rest at p_W, trimmed for the constant wind. @throws std::invalid_argument if not finite
  Quadrotor(const AirframeConfig& config, const Eigen::Vector3d& p_W, double yaw,
            std::uint64_t seed);

  void command(const core::VelocityCommand& command) override;
  void advance(double dt) override;  ///< whole inner steps; a remainder is made up for later
  [[nodiscard]] double time() const override { return kStep * static_cast<double>(steps_); }
  [[nodiscard]] const MotionSample& sample() const override { return sample_; }

  [[nodiscard]] double thrust() const { return thrust_; }              ///< [m/s^2] per unit of mass
  [[nodiscard]] const Eigen::Vector3d& gust() const { return gust_; }  ///< [m/s]

 private:
  struct Waiting
  {
    double t;
    core::VelocityCommand command;
  };
  void step();
  void blow();
  [[nodiscard]] Eigen::Vector3d wantedThrust();
  [[nodiscard]] Eigen::Vector3d withinLimits(const Eigen::Vector3d& thrust) const;
  void turn(const Eigen::Vector3d& thrust_W);

  AirframeConfig config_;
  core::Rng rng_;
  std::int64_t steps_ = 0;
  double behind_ = 0.0;  // [s] asked for and not yet flown
  std::deque<Waiting> waiting_;
  core::VelocityCommand obeyed_;
  Eigen::Vector3d p_, v_, a_, integral_, gust_, w_B_;
  Eigen::Quaterniond q_WB_;
  double thrust_ = kGravity;
  double heading_, heading_rate_ = 0.0;  // that the yaw loop follows
  MotionSample sample_;
};

}  // namespace slalom::simulation
