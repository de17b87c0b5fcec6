// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

#include "BlockBandCholesky.h"
#include "PathPart.h"
#include "slalom/core/SolveReport.h"

namespace slalom::optim::detail
{
/// Absolute tolerances and typical sizes of one program.
struct PathScale
{
  double length = 1.0;                        ///< [m] typical slack
  double price = 1.0;                         ///< typical multiplier
  double primal = 0.0, dual = 0.0, mu = 0.0;  ///< tolerances; mu is the mean of s.z
  double fraction = 0.995;  ///< [1] of the way to the boundary that a step may use
  int max_iterations = 50;
};

/// Mehrotra's predictor-corrector for the sum of two parts over a chain of points, one factor of a
/// block-banded matrix per iteration.
class PathInteriorPoint
{
 public:
  /// @param band block bandwidth of the objective, 1 or 2
  PathInteriorPoint(PathPart& objective, PathPart& rows, Eigen::Matrix3Xd start, Eigen::Index band,
                    const PathScale& scale);

  /// Fills everything but cost and primal_residual, which the caller measures on its own terms.
  [[nodiscard]] core::SolveReport run();
  [[nodiscard]] const Eigen::Matrix3Xd& points() const { return p_; }

 private:
  void linearize();
  [[nodiscard]] bool converged() const;
  [[nodiscard]] bool iterate();
  [[nodiscard]] Reach direction(double centre, bool corrected);

  PathPart &objective_, &rows_;
  const PathScale scale_;
  BlockBand matrix_;
  BlockBandCholesky cholesky_;
  Eigen::Matrix3Xd p_, gradient_, step_;
  PartState state_;
};

}  // namespace slalom::optim::detail
