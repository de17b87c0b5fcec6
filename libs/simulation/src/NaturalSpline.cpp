// SPDX-License-Identifier: BSD-3-Clause
#include "NaturalSpline.h"

#include <algorithm>

namespace slalom::simulation::detail
{
NaturalSpline::NaturalSpline(std::vector<double> times, std::vector<Eigen::Vector4d> values)
    : times_(std::move(times)), values_(std::move(values))
{
  const std::size_t n = times_.size();
  curvatures_.assign(n, Eigen::Vector4d::Zero());
  // Thomas algorithm for the continuity of the slopes; both ends have zero curvature.
  std::vector<double> upper(n, 0.0);
  for (std::size_t i = 1; i + 1 < n; ++i)
  {
    const double before = times_[i] - times_[i - 1], after = times_[i + 1] - times_[i];
    const Eigen::Vector4d rhs =
        6.0 * ((values_[i + 1] - values_[i]) / after - (values_[i] - values_[i - 1]) / before);
    const double pivot = 2.0 * (before + after) - before * upper[i - 1];
    upper[i] = after / pivot;
    curvatures_[i] = (rhs - before * curvatures_[i - 1]) / pivot;
  }
  for (std::size_t i = n - 1; i-- > 1;) curvatures_[i] -= upper[i] * curvatures_[i + 1];
}

NaturalSpline::Sample NaturalSpline::at(double t) const
{
  if (t < start() || t > end())
    return {t < start() ? values_.front() : values_.back(), Eigen::Vector4d::Zero(),
            Eigen::Vector4d::Zero()};
  const auto above = std::upper_bound(times_.begin() + 1, times_.end() - 1, t);
  const std::size_t i = static_cast<std::size_t>(above - times_.begin()) - 1;
  const double h = times_[i + 1] - times_[i], b = (t - times_[i]) / h, a = 1.0 - b;
  const Eigen::Vector4d &m0 = curvatures_[i], &m1 = curvatures_[i + 1];
  return {a * values_[i] + b * values_[i + 1] +
              ((a * a * a - a) * m0 + (b * b * b - b) * m1) * (h * h / 6.0),
          (values_[i + 1] - values_[i]) / h +
              ((3.0 * b * b - 1.0) * m1 - (3.0 * a * a - 1.0) * m0) * (h / 6.0),
          a * m0 + b * m1};
}

}  // namespace slalom::simulation::detail
