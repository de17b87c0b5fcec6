// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <functional>

#include "slalom/core/Deadline.h"
#include "slalom/core/SolveReport.h"

namespace slalom::optim
{
/// Value at x; fills the gradient (same size as x).
using CostFunction = std::function<double(const Eigen::VectorXd& x, Eigen::VectorXd& gradient)>;

struct BoxMinimizerConfig
{
  int max_evaluations = 60;          ///< [1] cost evaluations
  double relative_tolerance = 1e-4;  ///< [1] stop when the cost changes less
  int memory = 10;                   ///< [1] L-BFGS pairs
};

struct BoxMinimum
{
  Eigen::VectorXd x;  ///< best point seen, inside the box; the start if the solver failed at once
  core::SolveReport report;
};

/** min f(x) s.t. lower <= x <= upper by NLopt's L-BFGS (the paper's L-BFGS-B). `start` is clipped
 * into the box. Never throws on numerical trouble: the report says what happened. Thread-safe, no
 * global state. */
[[nodiscard]] BoxMinimum minimizeInBox(const CostFunction& cost, const Eigen::VectorXd& start,
                                       const Eigen::VectorXd& lower, const Eigen::VectorXd& upper,
                                       const BoxMinimizerConfig& config,
                                       const core::Deadline& deadline);

}  // namespace slalom::optim
