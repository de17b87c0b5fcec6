// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <vector>

namespace slalom::simulation::detail
{
/// Natural cubic spline in R^4 through values at increasing times; twice continuously
/// differentiable, constant outside.
class NaturalSpline
{
 public:
  /// @pre times increase strictly, at least two, as many values
  NaturalSpline(std::vector<double> times, std::vector<Eigen::Vector4d> values);

  struct Sample
  {
    Eigen::Vector4d value, first, second;  ///< and derivatives
  };
  [[nodiscard]] Sample at(double t) const;
  [[nodiscard]] double start() const { return times_.front(); }
  [[nodiscard]] double end() const { return times_.back(); }

 private:
  std::vector<double> times_;
  std::vector<Eigen::Vector4d> values_, curvatures_;  // second derivatives at the knots
};

}  // namespace slalom::simulation::detail
