// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <deque>

#include "slalom/core/VelocityResponse.h"
#include "slalom/simulation/Airframe.h"

namespace slalom::simulation
{
/** A multirotor under a velocity autopilot:
 *
 *    v' = (u - v) / lag + drag wind, |v'| <= max_acceleration,   p' = v,   likewise the yaw rate
 *
 *  with the command u of command_delay ago. Solved in closed form between two commands, so that the
 * result does not depend on the size of the steps. The body tilts towards a_W + g e_z, smoothed by
 * attitude_lag. */
class SimulatedVehicle : public VehicleModel
{
 public:
  /// At rest at p_W. @throws std::invalid_argument if that is not finite
  SimulatedVehicle(const AirframeConfig& config, const Eigen::Vector3d& p_W, double yaw);

  void command(const core::VelocityCommand& command) override;
  void advance(double dt) override;

  [[nodiscard]] double time() const override { return t_; }
  [[nodiscard]] const core::Motion& motion() const { return motion_; }
  [[nodiscard]] const MotionSample& sample() const override { return sample_; }

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
