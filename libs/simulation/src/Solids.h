// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <optional>

namespace slalom::simulation::detail
{
/// A set of solids that answers rays and distances; immutable.
class Solids
{
 public:
  virtual ~Solids() = default;
  /// First solid at 0 <= t <= max_range along the unit vector `direction`.
  [[nodiscard]] virtual std::optional<double> castRay(const Eigen::Vector3d& origin,
                                                      const Eigen::Vector3d& direction,
                                                      double max_range) const = 0;
  /// Signed distance; +infinity without solids.
  [[nodiscard]] virtual double distance(const Eigen::Vector3d& p) const = 0;
  [[nodiscard]] virtual Eigen::AlignedBox3d bounds() const = 0;  ///< empty without solids
};

/// Interval of the ray parameter; empty when enter > leave.
struct Interval
{
  double enter, leave;
};

/// Where the line origin + t direction is between lo and hi on one axis, cut with `with`.
[[nodiscard]] inline Interval slab(double origin, double direction, double lo, double hi,
                                   Interval with)
{
  if (direction == 0.0) return origin >= lo && origin <= hi ? with : Interval{1.0, 0.0};
  const double a = (lo - origin) / direction, b = (hi - origin) / direction;
  return {std::max(with.enter, std::min(a, b)), std::min(with.leave, std::max(a, b))};
}

}  // namespace slalom::simulation::detail
