// SPDX-License-Identifier: BSD-3-Clause
#include "Plan.h"

#include <algorithm>
#include <cmath>

namespace slalom::local_planner::detail
{
namespace
{
Eigen::Vector4d clampTo(const Eigen::Vector4d& value, const Eigen::Vector4d& lower,
                        const Eigen::Vector4d& upper)
{
  return value.cwiseMax(lower).cwiseMin(upper);
}
}  // namespace

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

Eigen::Matrix4Xd rollOut(const Eigen::Vector4d& start, const Eigen::Matrix4Xd& inputs, double step)
{
  Eigen::Matrix4Xd states(4, inputs.cols() + 1);
  states.col(0) = start;
  for (Eigen::Index k = 0; k < inputs.cols(); ++k)
    states.col(k + 1) = states.col(k) + step * inputs.col(k);
  return states;
}

Plan pursue(const Eigen::Vector4d& start, const Eigen::Vector4d& last_input,
            const HorizonReference& reference, double step, const core::Vehicle& vehicle)
{
  constexpr double kSettle = 0.5;  // [s] in which a deviation is to be made good
  const Eigen::Vector4d limit(vehicle.max_speed_mps, vehicle.max_speed_mps, vehicle.max_speed_mps,
                              vehicle.max_yaw_rate_radps);
  Eigen::Vector4d change = Eigen::Vector4d::Constant(vehicle.max_acceleration_mps2 * step);
  change[3] = 2.0 * vehicle.max_yaw_rate_radps;
  Plan plan{0.0, {}, Eigen::Matrix4Xd(4, reference.inputs.cols())};
  Eigen::Vector4d state = start, input = last_input;
  for (Eigen::Index k = 0; k < reference.inputs.cols(); ++k)
  {
    const Eigen::Vector4d wanted =
        reference.inputs.col(k) + (reference.states.col(k) - state) / kSettle;
    input = clampTo(clampTo(wanted, input - change, input + change), -limit, limit);
    state += step * input;
    plan.inputs.col(k) = input;
  }
  plan.states = rollOut(start, plan.inputs, step);
  return plan;
}

}  // namespace slalom::local_planner::detail
