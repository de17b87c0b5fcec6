// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

#include "HorizonReference.h"
#include "slalom/core/Vehicle.h"

namespace slalom::local_planner::detail
{
/// A predicted motion: held inputs and the states they lead through. Columns as in NmpcData.
struct Plan
{
  double t = 0.0;           ///< [s] log time of stage 0
  Eigen::Matrix4Xd states;  ///< 4x(N+1)
  Eigen::Matrix4Xd inputs;  ///< 4xN
};

/// The inputs of `plan` as seen `elapsed` seconds later; the last one is held beyond the end.
[[nodiscard]] Eigen::Matrix4Xd shiftedInputs(const Plan& plan, double elapsed, double step);

/// States from `start` under `inputs`.
[[nodiscard]] Eigen::Matrix4Xd rollOut(const Eigen::Vector4d& start, const Eigen::Matrix4Xd& inputs,
                                       double step);

/** A first guess without a previous plan: pursue the reference within the limits of speed and
 * acceleration, from `start` and the input in effect. */
[[nodiscard]] Plan pursue(const Eigen::Vector4d& start, const Eigen::Vector4d& last_input,
                          const HorizonReference& reference, double step,
                          const core::Vehicle& vehicle);

}  // namespace slalom::local_planner::detail
