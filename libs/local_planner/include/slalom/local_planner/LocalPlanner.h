// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "slalom/core/Deadline.h"
#include "slalom/core/DistanceField.h"
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
  None,     ///< a fresh NMPC solution
  Shifted,  ///< the previous solution, shifted in time
  Brake     ///< decelerate to a stop
};
[[nodiscard]] std::string_view toString(Fallback fallback);

/// Everything a step may look at: log it, replay it.
struct LocalPlannerInput
{
  core::VehicleState state;  ///< closed loop: the estimate, not the last prediction
  std::shared_ptr<const core::DistanceField> field;  ///< null: no obstacle rows
  std::shared_ptr<const spline::UniformBSpline>
      reference;          ///< refined reference, local frame; null: brake
  double progress = 0.0;  ///< [s] parameter on the reference at state.t
  std::shared_ptr<const spline::TimeLaw>
      law;  ///< how fast the parameter runs, and where it rests; goes with `reference`
  core::VelocityCommand last_command;
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
 * multiple shooting. State x = [position, yaw], input u = [velocity (world axes), yaw rate];
 * velocity reference from the spline, heading along the path (unwrapped), obstacle distances with
 * exact-penalty slack from stage 1 on, input and acceleration limits. Obstacle distances are
 * linearised along the expected motion (deviation D-08). The only state is the warm start; reset()
 * clears it. Never throws after construction, which throws std::invalid_argument on a value out of
 * its range.
 *
 *  If the NMPC gives no plan that may be flown, the last one is flown on for at most 5 steps while
 * it stays free of obstacles, and after that the vehicle brakes. */
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
