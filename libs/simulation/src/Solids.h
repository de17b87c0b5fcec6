// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
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

inline constexpr double kNowhere = std::numeric_limits<double>::infinity();

/// Where a ray enters an upright cylinder whose foot is the origin; 0 inside, infinity if nowhere.
/// `direction` is a unit vector.
[[nodiscard]] inline double hitCylinder(const Eigen::Vector3d& origin,
                                        const Eigen::Vector3d& direction, double radius,
                                        double height)
{
  const double squared = radius * radius, a = direction.head<2>().squaredNorm();
  const double cross = origin.x() * direction.y() - origin.y() * direction.x();
  if (cross * cross > squared * a) return kNowhere;
  Interval inside{0.0, kNowhere};
  if (a > 0.0)
  {
    const double along = -(origin.x() * direction.x() + origin.y() * direction.y()) / a;
    const double half = std::sqrt(std::max(0.0, squared * a - cross * cross)) / a;
    inside = {std::max(0.0, along - half), along + half};
  }
  else if (origin.head<2>().squaredNorm() > squared)
    return kNowhere;
  inside = slab(origin.z(), direction.z(), 0.0, height, inside);
  return inside.enter <= inside.leave ? inside.enter : kNowhere;
}

/// Likewise a ball around the origin.
[[nodiscard]] inline double hitSphere(const Eigen::Vector3d& origin,
                                      const Eigen::Vector3d& direction, double radius)
{
  const double along = -origin.dot(direction);
  const double off = (origin + along * direction).squaredNorm();
  if (off > radius * radius) return kNowhere;
  const double half = std::sqrt(radius * radius - off);
  return along + half >= 0.0 ? std::max(0.0, along - half) : kNowhere;
}

/// Signed distance of p from an upright cylinder whose foot is the origin.
[[nodiscard]] inline double cylinderDistance(const Eigen::Vector3d& p, double radius, double height)
{
  const double side = p.head<2>().norm() - radius;
  const double cap = std::max(-p.z(), p.z() - height);
  if (side <= 0.0 || cap <= 0.0) return std::max(side, cap);
  return std::hypot(side, cap);
}

}  // namespace slalom::simulation::detail
