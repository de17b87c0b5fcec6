// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "SearchPlane.h"
#include "slalom/simulation/ShortestPath.h"

namespace slalom::simulation
{
namespace
{
using Eigen::Vector2d;
using Eigen::Vector2i;
using Eigen::Vector3d;
using Plane = detail::SearchPlane;

constexpr double kSpacing = 0.05;  // [m] of the grid

/// All nodes of a grid that the ball can come to from the origin of the plane.
class Flood
{
 public:
  explicit Flood(const Plane& plane) : plane_(plane)
  {
    const Eigen::AlignedBox2d area = plane.bounds();
    low_ = (area.min() / kSpacing).array().floor().cast<int>();
    size_ = (area.max() / kSpacing).array().ceil().cast<int>().matrix() - low_ + Vector2i(1, 1);
    rooms_.assign(std::size_t(size_.x()) * std::size_t(size_.y()), kUnknown);
    reached_.assign(rooms_.size(), false);
  }

  void run()
  {
    if (roomAt({0, 0}) < 0.0) return;
    std::vector<Vector2i> open{{0, 0}};
    reached_[index({0, 0})] = true;
    while (!open.empty())
    {
      const Vector2i here = open.back();
      open.pop_back();
      for (const Vector2i& step :
           {Vector2i(1, 0), Vector2i(-1, 0), Vector2i(0, 1), Vector2i(0, -1), Vector2i(1, 1),
            Vector2i(-1, 1), Vector2i(1, -1), Vector2i(-1, -1)})
        if (const Vector2i there = here + step;
            inside(there) && !reached_[index(there)] && passable(here, there))
        {
          reached_[index(there)] = true;
          open.push_back(there);
        }
    }
  }

  template <class Visit>
  void forReached(Visit&& visit) const
  {
    for (int y = 0; y < size_.y(); ++y)
      for (int x = 0; x < size_.x(); ++x)
        if (const Vector2i cell = low_ + Vector2i(x, y); reached_[index(cell)])
          visit(point(cell), double(rooms_[index(cell)]));
  }

 private:
  static constexpr float kUnknown = -std::numeric_limits<float>::infinity();

  [[nodiscard]] static Vector2d point(const Vector2i& cell)
  {
    return kSpacing * cell.cast<double>();
  }
  [[nodiscard]] bool inside(const Vector2i& cell) const
  {
    return ((cell - low_).array() >= 0).all() && ((cell - low_).array() < size_.array()).all();
  }
  [[nodiscard]] std::size_t index(const Vector2i& cell) const
  {
    return std::size_t(cell.y() - low_.y()) * std::size_t(size_.x()) +
           std::size_t(cell.x() - low_.x());
  }
  double roomAt(const Vector2i& cell)
  {
    float& room = rooms_[index(cell)];
    if (room == kUnknown) room = static_cast<float>(plane_.room(point(cell)));
    return room;
  }
  /// Room falls by no more than what is flown.
  bool passable(const Vector2i& a, const Vector2i& b)
  {
    const double there = roomAt(b);
    if (there < 0.0) return false;
    const double step = kSpacing * (b - a).cast<double>().norm();
    return roomAt(a) >= step || there >= step || plane_.seen(point(a), point(b));
  }

  const Plane& plane_;
  Vector2i low_, size_;
  std::vector<float> rooms_;  // [m] of each node, as far as asked for
  std::vector<bool> reached_;
};
}  // namespace

std::optional<Vector3d> nearestReachable(const World& world, const Vector3d& start_W,
                                         const Vector3d& goal_W, const Vector3d& from_W,
                                         double radius, double clearance)
{
  const Plane plane(world, start_W, goal_W, radius);
  Flood flood(plane);
  flood.run();
  const double wanted = clearance - radius;
  double least = std::numeric_limits<double>::infinity();
  flood.forReached(
      [&](const Vector2d& p, double room)
      {
        if (room >= wanted) least = std::min(least, (plane.inWorld(p) - goal_W).norm());
      });
  std::optional<Vector3d> nearest;
  double best = std::numeric_limits<double>::infinity();
  flood.forReached(
      [&](const Vector2d& p, double room)
      {
        const Vector3d p_W = plane.inWorld(p);
        if (room < wanted || (p_W - goal_W).norm() > least + kSpacing) return;
        if (const double away = (p_W - from_W).norm(); away < best)
        {
          best = away;
          nearest = p_W;
        }
      });
  return nearest;
}

}  // namespace slalom::simulation
