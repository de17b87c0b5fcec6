// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "slalom/core/Deadline.h"
#include "slalom/core/DistanceField.h"
#include "slalom/core/MovingObstacle.h"
#include "slalom/core/SolveReport.h"
#include "slalom/core/Vehicle.h"
#include "slalom/core/VehicleState.h"
#include "slalom/local_planner/LocalPlannerConfig.h"
#include "slalom/spline/TimeLaw.h"
#include "slalom/spline/UniformBSpline.h"

namespace slalom::local_planner
{
/// Which rung of the ladder produced the command.
enum class Fallback
{
  None,       ///< a fresh NMPC solution
  Shifted,    ///< the previous solution, shifted in time
  Committed,  ///< the committed reference, pursued without optimising
  Brake       ///< decelerate to a stop
};
[[nodiscard]] std::string_view toString(Fallback fallback);

/// Everything a step may look at: log it, replay it.
struct LocalPlannerInput
{
  core::VehicleState state;  ///< estimated, for the moment at which the command takes effect
  std::shared_ptr<const core::DistanceField> field;  ///< null: no obstacle rows
  std::shared_ptr<const spline::UniformBSpline>
      reference;          ///< refined reference, local frame; null: brake
  double progress = 0.0;  ///< [s] parameter on the reference at state.t
  std::shared_ptr<const spline::TimeLaw>
      law;  ///< how fast the parameter runs, and where it rests; goes with `reference`
  /// [m] where the vehicle's centre is to stay; as wide as all space unless somebody says so
  Eigen::AlignedBox3d airspace_L{Eigen::Vector3d::Constant(-1e6), Eigen::Vector3d::Constant(1e6)};
  std::vector<core::MovingObstacle> movers;  ///< to keep away from, besides those of the field
  Eigen::Vector3d disturbance_W = Eigen::Vector3d::Zero();  ///< [m/s^2] that the lag model lacks
  core::VelocityCommand last_command;
  double elapsed_s = 0.0;  ///< [s] since it was sent; 0: since the last step
  core::Deadline deadline = core::Deadline::none();
};

struct LocalPlannerOutput
{
  core::VelocityCommand command;  ///< finite and inside the vehicle's limits, always
  Eigen::Matrix3Xd horizon_L;     ///< predicted positions, 3x(N+1) [m]
  Eigen::VectorXd horizon_yaw;    ///< [rad] N+1, continuous
  std::vector<Eigen::Vector3d> close_obstacles_L;  ///< C_o
  Fallback fallback = Fallback::None;
  core::SolveReport report;
  double worst_obstacle_slack_m = 0.0;  ///< how far the plan enters the asked-for distance
  std::string reason;                   ///< one line
};

/** One step of the local planner [Paper Algorithm 1, local part; Eq. (9)]: P_tn, C_o, NMPC by
 * multiple shooting. State x = [position, velocity, yaw, yaw rate], input u = [velocity command
 * (world axes), yaw rate command] which the vehicle follows with its lags; without lags this is the
 * kinematic model of the paper. Feed-forward from the spline, heading along the path (unwrapped),
 * rows that keep away from obstacles with exact-penalty slack from stage 1 on, at the last stage
 * also where braking would end, input and acceleration limits. Obstacle distances are linearised
 * along the expected motion (deviation D-08). The only state is the warm start; reset() clears it.
 * Never throws after construction, which throws std::invalid_argument on a value out of its range.
 *
 *  The ladder, if the NMPC gives no plan that may be flown: the last one is flown on for at most 5
 *  steps; after that the committed reference is pursued without optimising; each only while it
 *  stays free of obstacles. Else the vehicle brakes, and goes on only after three good solutions in
 *  a row. After three failures the warm start is dropped. */
class LocalPlanner
{
 public:
  LocalPlanner(const LocalPlannerConfig& config, const core::Vehicle& vehicle);
  ~LocalPlanner();
  LocalPlanner(LocalPlanner&&) noexcept;
  LocalPlanner& operator=(LocalPlanner&&) noexcept;

  [[nodiscard]] LocalPlannerOutput step(const LocalPlannerInput& input);
  void reset();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace slalom::local_planner
