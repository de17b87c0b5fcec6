// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <optional>

#include "slalom/simulation/World.h"

namespace slalom::simulation::detail
{
inline constexpr double kTolerance = 1e-4;  ///< [m] of free
inline constexpr double kStride = 5e-3;     ///< [m] least step along a line that grazes something

/// The plane through start and goal, with its coordinates: x from start to goal, y across, level.
class SearchPlane
{
 public:
  SearchPlane(const World& world, const Eigen::Vector3d& start, const Eigen::Vector3d& goal,
              double radius)
      : world_(world), start_(start), radius_(radius), length((goal - start).norm())
  {
    x_ = length > 0.0 ? Eigen::Vector3d((goal - start) / length) : Eigen::Vector3d::UnitX();
    const Eigen::Vector3d level(-x_.y(), x_.x(), 0.0);
    y_ = level.norm() > 1e-9 ? level.normalized() : Eigen::Vector3d::UnitY();
  }
  [[nodiscard]] Eigen::Vector3d inWorld(const Eigen::Vector2d& p) const
  {
    return start_ + p.x() * x_ + p.y() * y_;
  }
  /// What is left of the distance when the ball is there.
  [[nodiscard]] double room(const Eigen::Vector2d& p) const
  {
    return world_.distance(inWorld(p)) - radius_ + kTolerance;
  }
  /// A point at most `reach` away where the ball is free; nullopt if none was found.
  [[nodiscard]] std::optional<Eigen::Vector2d> freeNear(const Eigen::Vector2d& p,
                                                        double reach) const
  {
    constexpr double kSpare = 1e-3, kProbe = 1e-4;  // [m]
    constexpr int kTries = 3;
    Eigen::Vector2d at = p;
    for (int k = 0; k < kTries; ++k)
    {
      const double free = room(at);
      if (free >= 0.0) return at;
      if (free < -reach) return std::nullopt;
      const Eigen::Vector2d x(kProbe, 0.0), y(0.0, kProbe);
      const Eigen::Vector2d away(room(at + x) - room(at - x), room(at + y) - room(at - y));
      at += (kSpare - free) * away.stableNormalized();
      if ((at - p).norm() > reach) return std::nullopt;
    }
    return room(at) >= 0.0 ? std::optional(at) : std::nullopt;
  }
  [[nodiscard]] bool seen(const Eigen::Vector2d& a, const Eigen::Vector2d& b) const
  {
    const double whole = (b - a).norm();
    for (double s = 0.0; s < whole;)
    {
      const double free = room(a + (b - a) * (s / whole));
      if (free < 0.0) return false;
      s += std::max(free, kStride);
    }
    return room(b) >= 0.0;
  }
  [[nodiscard]] Eigen::AlignedBox2d bounds() const
  {
    const Eigen::AlignedBox3d box = world_.bounds();
    Eigen::AlignedBox2d area(Eigen::Vector2d(0.0, 0.0));
    area.extend(Eigen::Vector2d(length, 0.0));
    for (int k = 0; k < 8; ++k)
    {
      const Eigen::Vector3d corner =
          box.corner(static_cast<Eigen::AlignedBox3d::CornerType>(k)) - start_;
      area.extend(Eigen::Vector2d(corner.dot(x_), corner.dot(y_)));
    }
    return area;
  }

 private:
  const World& world_;
  Eigen::Vector3d start_, x_, y_;
  double radius_;

 public:
  const double length;
};

}  // namespace slalom::simulation::detail
