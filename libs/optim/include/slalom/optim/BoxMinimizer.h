// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

#include "slalom/core/Deadline.h"
#include "slalom/core/SolveReport.h"
#include "slalom/optim/BandedCost.h"

namespace slalom::optim
{
enum class BoxMethod
{
  /// Second order, O(points) per iteration. A LimitedCost is first approached by a primal-dual
  /// interior point, for which its kinks are bounds; any cost is then finished by a projected
  /// Newton method with line search.
  Newton,
  /// L-BFGS of NLopt, as in the paper: gradients only, any number of variables.
  Lbfgs
};

struct BoxMinimizerConfig
{
  BoxMethod method = BoxMethod::Newton;
  int max_evaluations = 60;  ///< [1] cost evaluations
  /// [1] Lbfgs: stop when the cost changes less. Newton: stop when the decrease that is left, as
  /// gradient and curvature predict it, is less.
  double relative_tolerance = 1e-4;
  int memory = 10;  ///< [1] L-BFGS pairs
};

struct BoxMinimum
{
  Eigen::VectorXd x;    ///< best point seen, inside the box; the start if the solver failed at once
  int evaluations = 0;  ///< of the cost
  /// dual_residual: largest move of a unit gradient step that the box permits, zero exactly at a
  /// KKT point. iterations: factorisations (Newton) or evaluations (Lbfgs).
  core::SolveReport report;
};

/** min f(x) s.t. lower <= x <= upper for a smooth cost (Newton: C1 and piecewise C2 suffices).
 *
 *  `start` is clipped into the box. The cost is evaluated inside the box only, and the cost of the
 * result never exceeds that of the clipped start. Bounds may be infinite or equal. Never throws on
 * numerical trouble, not even what the cost throws: the report says what happened, and x is the
 * best point seen. Deterministic unless the deadline strikes; thread-safe, no global state. */
[[nodiscard]] BoxMinimum minimizeInBox(BandedCost& cost, const Eigen::VectorXd& start,
                                       const Eigen::VectorXd& lower, const Eigen::VectorXd& upper,
                                       const BoxMinimizerConfig& config,
                                       const core::Deadline& deadline);

}  // namespace slalom::optim
