// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <algorithm>

#include "BlockBandCholesky.h"

namespace slalom::optim::detail
{
/// How far a direction can be followed, and what becomes of the complementarity on the way:
/// now + step * linear + step^2 * quadratic.
struct Reach
{
  double step = 1.0, linear = 0.0, quadratic = 0.0;

  Reach& operator+=(const Reach& other)
  {
    step = std::min(step, other.step);
    linear += other.linear;
    quadratic += other.quadratic;
    return *this;
  }
};

/// Where a part stands in the KKT conditions.
struct PartState
{
  double pairs = 0.0;            ///< degree of its cones
  double complementarity = 0.0;  ///< sum of s.z over them
  double primal_residual = 0.0, multiplier_residual = 0.0, largest_multiplier = 0.0;

  PartState& operator+=(const PartState& other)
  {
    pairs += other.pairs;
    complementarity += other.complementarity;
    primal_residual = std::max(primal_residual, other.primal_residual);
    multiplier_residual = std::max(multiplier_residual, other.multiplier_residual);
    largest_multiplier = std::max(largest_multiplier, other.largest_multiplier);
    return *this;
  }
  [[nodiscard]] double mu() const { return pairs > 0.0 ? complementarity / pairs : 0.0; }
};

/** One part of a convex program over a chain of points: a term of its cost or its constraints,
 * with whatever slacks and multipliers it has. A part eliminates those itself and shows to the
 * interior point only 3x3 blocks and one force per point. The order of calls in an iteration:
 * linearize, then (addRightHandSide, expand) for the predictor and the corrector, then move. */
class PathPart
{
 public:
  virtual ~PathPart() = default;

  /// Strictly interior slacks and multipliers; `length` and `price` are typical slack and
  /// multiplier.
  virtual void initialize(const Eigen::Matrix3Xd& p, double length, double price) = 0;
  /// Adds the condensed curvature and the force (gradient of the Lagrangian) at p.
  virtual PartState linearize(const Eigen::Matrix3Xd& p, BlockBand& matrix,
                              Eigen::Matrix3Xd& gradient) = 0;
  /// Adds what eliminating the slacks leaves on the right-hand side for the target s.z = centre,
  /// minus the second-order term of the last direction if `corrected`.
  virtual void addRightHandSide(double centre, bool corrected, Eigen::Matrix3Xd& rhs) = 0;
  /// Direction of slacks and multipliers that belongs to dp.
  virtual Reach expand(const Eigen::Matrix3Xd& dp) = 0;
  virtual void move(double step) = 0;
};

}  // namespace slalom::optim::detail
