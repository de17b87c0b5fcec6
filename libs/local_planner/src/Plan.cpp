// SPDX-License-Identifier: BSD-3-Clause
#include "Plan.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace slalom::local_planner::detail
{
core::Motion motionOf(const core::VehicleState& state)
{
  return {state.p_L, state.v_W, state.yaw(), (state.q_WB * state.w_B).z()};
}

Eigen::Matrix4Xd shiftedInputs(const Plan& plan, double elapsed, double step)
{
  const Eigen::Index n = plan.inputs.cols();
  Eigen::Matrix4Xd shifted(4, n);
  for (Eigen::Index k = 0; k < n; ++k)
  {
    // The new interval straddles two old ones: their mean keeps the distance covered.
    const double at = std::max(0.0, elapsed / step) + static_cast<double>(k);
    const double whole = std::min(std::floor(at), static_cast<double>(n - 1));
    const auto i = static_cast<Eigen::Index>(whole);
    const Eigen::Index next = std::min(i + 1, n - 1);
    shifted.col(k) = plan.inputs.col(i) +
                     std::min(1.0, at - whole) * (plan.inputs.col(next) - plan.inputs.col(i));
  }
  return shifted;
}

Plan rollOut(double t, const core::Motion& start, Eigen::Matrix4Xd inputs, const Model& model)
{
  const Eigen::Index n = inputs.cols();
  Plan plan{t, Eigen::Matrix3Xd(3, n + 1), Eigen::Matrix3Xd(3, n + 1), Eigen::VectorXd(n + 1),
            std::move(inputs)};
  core::Motion motion = start;
  for (Eigen::Index k = 0; k <= n; ++k)
  {
    plan.positions.col(k) = motion.p;
    plan.velocities.col(k) = motion.v;
    plan.yaw[k] = motion.yaw;
    if (k < n) motion = model.after(motion, plan.inputs.col(k));
  }
  return plan;
}

Plan pursue(double t, const core::Motion& start, const Eigen::Vector4d& last_input,
            const HorizonReference& reference, const Model& model)
{
  constexpr double kSettle = 0.5;  // [s]
  const core::Vehicle& vehicle = model.vehicle;
  const Eigen::Vector4d limit(vehicle.max_speed_mps, vehicle.max_speed_mps, vehicle.max_speed_mps,
                              vehicle.max_yaw_rate_radps);
  Eigen::Vector4d change = Eigen::Vector4d::Constant(vehicle.max_acceleration_mps2 * model.step);
  change[3] = 2.0 * vehicle.max_yaw_rate_radps;
  Eigen::Matrix4Xd inputs(4, reference.commands.cols());
  core::Motion motion = start;
  Eigen::Vector4d input = last_input;
  for (Eigen::Index k = 0; k < inputs.cols(); ++k)
  {
    Eigen::Vector4d wanted;
    wanted << reference.commands.col(k) + (reference.positions.col(k) - motion.p) / kSettle,
        reference.yaw_rates[k] + (reference.yaw[k] - motion.yaw) / kSettle;
    input = wanted.cwiseMax(input - change).cwiseMin(input + change);
    input = input.cwiseMax(-limit).cwiseMin(limit);
    motion = model.after(motion, input);
    inputs.col(k) = input;
  }
  return rollOut(t, start, std::move(inputs), model);
}

}  // namespace slalom::local_planner::detail
