// SPDX-License-Identifier: BSD-3-Clause
#include "Nmpc.h"

#include <algorithm>

namespace slalom::local_planner::detail
{
namespace
{
using core::VelocityResponse;
using Eigen::Vector3d;

constexpr double kFarthestPull = 1.5;  // [m] of the reference from the expected position
constexpr double kTail = 4.0;          // the last stage counts for this many
constexpr double kDirected = 0.1;      // [m/s] slower than this the reference has no direction

optim::TrackingSolverConfig solverConfig(const LocalPlannerConfig& config)
{
  return {config.solver, config.tolerance, config.max_iterations};
}

/// Across the reference `across`, along it `along`.
Eigen::Matrix3d weightAlong(const Vector3d& velocity, double across, double along)
{
  const double speed = velocity.norm();
  if (speed < kDirected) return across * Eigen::Matrix3d::Identity();
  const Vector3d t = velocity / speed;
  return across * Eigen::Matrix3d::Identity() + (along - across) * t * t.transpose();
}

/// A bounded pull keeps the penalty on obstacles exact however far the reference has run ahead.
Vector3d pulled(const Vector3d& wanted, const Vector3d& expected)
{
  const Vector3d away = wanted - expected;
  return expected + away * std::min(1.0, kFarthestPull / std::max(away.norm(), 1e-9));
}

/// One report of both programs: as good as the worse.
core::SolveReport both(const core::SolveReport& motion, const core::SolveReport& heading)
{
  core::SolveReport report = motion.converged() ? heading : motion;
  report.iterations = std::max(motion.iterations, heading.iterations);
  report.cost = motion.cost + heading.cost;
  report.primal_residual = std::max(motion.primal_residual, heading.primal_residual);
  report.dual_residual = std::max(motion.dual_residual, heading.dual_residual);
  report.wall_time = motion.wall_time + heading.wall_time;
  return report;
}
}  // namespace

Nmpc::Nmpc(const LocalPlannerConfig& config, const core::Vehicle& vehicle)
    : config_(config),
      motion_(config.horizon, mostRows(config)),
      heading_(config.horizon, 0),
      motion_solver_(
          optim::makeTrackingSolver<3>(solverConfig(config), config.horizon, mostRows(config))),
      heading_solver_(optim::makeTrackingSolver<1>(solverConfig(config), config.horizon, 0))
{
  for (optim::TrackingStage<3>& stage : motion_.stages)
  {
    stage.response = VelocityResponse::over(config.step_s, vehicle.velocity_lag_s);
    stage.velocity_weight = config.weight_velocity;
    stage.input_weight = config.weight_command;
    stage.change_weight = config.weight_rate;
    stage.input_limit.setConstant(vehicle.max_speed_mps);
    stage.change_limit.setConstant(vehicle.max_acceleration_mps2 * config.step_s);
  }
  for (optim::TrackingStage<1>& stage : heading_.stages)
  {
    stage.response = VelocityResponse::over(config.step_s, vehicle.yaw_rate_lag_s);
    stage.position_weight.setConstant(config.weight_yaw);
    stage.input_weight = config.weight_yaw_rate;
    stage.change_weight = config.weight_rate;
    stage.input_limit.setConstant(vehicle.max_yaw_rate_radps);
  }
  heading_.stages.back().position_weight *= kTail;
}

void Nmpc::setMotion(const NmpcStart& start, const HorizonReference& reference, const Plan& guess,
                     const Model& model)
{
  motion_.p = start.motion.p;
  motion_.v = start.motion.v;
  motion_.u_before = start.last_input.head<3>();
  Vector3d before = reference.commands.col(0) - start.elapsed * reference.acceleration;
  for (int k = 0; k < config_.horizon; ++k)
  {
    optim::TrackingStage<3>& stage = motion_.stages[static_cast<std::size_t>(k)];
    stage.drift_p = stage.response.p_u * model.offset();
    stage.drift_v = stage.response.v_u * model.offset();
    stage.position = pulled(reference.positions.col(k + 1), guess.positions.col(k + 1));
    stage.input = reference.commands.col(k);
    stage.velocity = stage.response.v_v * reference.velocities.col(k) +
                     stage.response.v_u * (stage.input + model.offset());
    stage.change = stage.input - before;
    before = stage.input;
    stage.position_weight =
        weightAlong(reference.velocities.col(k + 1), config_.weight_position, config_.weight_lag);
  }
  motion_.stages.front().change_limit.setConstant(model.vehicle.max_acceleration_mps2 *
                                                  start.elapsed);
  motion_.stages.back().position_weight *= kTail;
}

void Nmpc::setRows(const KeepOuts& keep_outs)
{
  for (std::size_t k = 0; k < keep_outs.stages.size(); ++k)
  {
    const std::vector<KeepOut>& rows = keep_outs.stages[k];
    motion_.row_counts[k] = static_cast<int>(rows.size());
    for (std::size_t j = 0; j < rows.size(); ++j)
      motion_.rows[k * static_cast<std::size_t>(motion_.max_rows) + j] = {
          rows[j].normal, rows[j].lead, rows[j].offset, config_.obstacle_penalty};
  }
}

void Nmpc::setHeading(const NmpcStart& start, const HorizonReference& reference)
{
  heading_.p[0] = start.motion.yaw;
  heading_.v[0] = start.motion.yaw_rate;
  heading_.u_before[0] = start.last_input[3];
  double before = reference.yaw_rates[0];
  for (int k = 0; k < config_.horizon; ++k)
  {
    optim::TrackingStage<1>& stage = heading_.stages[static_cast<std::size_t>(k)];
    stage.position[0] = reference.yaw[k + 1];
    stage.input[0] = reference.yaw_rates[k];
    stage.change[0] = reference.yaw_rates[k] - before;
    before = reference.yaw_rates[k];
  }
}

Nmpc::Result Nmpc::solve(const NmpcStart& start, const HorizonReference& reference,
                         const KeepOuts& keep_outs, const Plan& guess, const Model& model,
                         const core::Deadline& deadline)
{
  setMotion(start, reference, guess, model);
  setRows(keep_outs);
  setHeading(start, reference);
  const auto& motion = motion_solver_->solve(motion_, guess.inputs.topRows<3>(), deadline);
  const auto& heading = heading_solver_->solve(heading_, guess.inputs.row(3), deadline);
  Eigen::Matrix4Xd inputs(4, config_.horizon);
  inputs << motion.inputs, heading.inputs;
  return {rollOut(start.t, start.motion, std::move(inputs), model),
          both(motion.report, heading.report), motion.worst_slack};
}

}  // namespace slalom::local_planner::detail
