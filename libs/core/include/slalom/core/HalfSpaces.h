// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

namespace slalom::core
{
/// The convex set { x : A x <= b }, rows of A of unit length [1], b in metres.
struct HalfSpaces
{
  Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor> A;
  Eigen::VectorXd b;

  [[nodiscard]] Eigen::Index rows() const { return b.size(); }

  /// Largest A x - b over the rows: <= 0 inside, the distance by which the worst plane is violated
  /// outside.
  [[nodiscard]] double violation(const Eigen::Vector3d& x) const
  {
    return rows() == 0 ? -1e300 : (A * x - b).maxCoeff();
  }
  [[nodiscard]] bool contains(const Eigen::Vector3d& x, double tolerance = 0.0) const
  {
    return violation(x) <= tolerance;
  }
};

}  // namespace slalom::core
