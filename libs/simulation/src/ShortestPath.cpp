// SPDX-License-Identifier: BSD-3-Clause
#include "slalom/simulation/ShortestPath.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <queue>
#include <vector>

#include "SearchPlane.h"

namespace slalom::simulation
{
namespace
{
using detail::kStride;
using Eigen::Vector2d;
using Eigen::Vector2i;
using Eigen::Vector3d;
using Plane = detail::SearchPlane;

constexpr double kSpacing = 0.05;   // [m] of the grid, about
constexpr double kMostNodes = 4e6;  // of the grid: about 100 x 100 m

/// Lazy Theta*: a node believes that its parent's parent sees it, and finds out when its turn
/// comes.
class Search
{
 public:
  explicit Search(const Plane& plane)
      : plane_(plane), spacing_(plane.length / std::max(1.0, std::ceil(plane.length / kSpacing)))
  {
    const Eigen::AlignedBox2d area = plane.bounds();
    low_ = (area.min() / spacing_).array().floor().cast<int>();
    size_ = (area.max() / spacing_).array().ceil().cast<int>().matrix() - low_ + Vector2i(1, 1);
    nodes_.resize(static_cast<std::size_t>(size_.x()) * static_cast<std::size_t>(size_.y()));
  }
  [[nodiscard]] std::vector<Vector2d> run();

 private:
  struct Node
  {
    double cost = std::numeric_limits<double>::infinity();
    std::int32_t parent = -1;
    float dx = 0.0F, dy = 0.0F;  // [m] off the grid: a blocked node moves to where it is free, so
                                 // that no gap falls between two nodes
    std::int8_t free = -1;       // not known yet
    bool closed = false;
  };
  [[nodiscard]] std::int32_t index(const Vector2i& cell) const
  {
    return (cell.y() - low_.y()) * size_.x() + cell.x() - low_.x();
  }
  [[nodiscard]] Vector2i cell(std::int32_t i) const
  {
    return {i % size_.x() + low_.x(), i / size_.x() + low_.y()};
  }
  [[nodiscard]] Vector2d point(std::int32_t i) const
  {
    const Node& node = nodes_[static_cast<std::size_t>(i)];
    return spacing_ * cell(i).cast<double>() + Vector2d(node.dx, node.dy);
  }
  [[nodiscard]] Node& at(std::int32_t i) { return nodes_[static_cast<std::size_t>(i)]; }
  template <class Visit>
  void forNeighbours(std::int32_t i, Visit&& visit);
  bool isFree(std::int32_t i);
  bool settle(std::int32_t i);
  void open(std::int32_t i, std::int32_t parent, double cost);

  const Plane& plane_;
  double spacing_;
  Vector2i low_, size_;
  std::vector<Node> nodes_;
  using Entry = std::pair<double, std::int32_t>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open_;
  Vector2d goal_;
};

template <class Visit>
void Search::forNeighbours(std::int32_t i, Visit&& visit)
{
  const Vector2i here = cell(i);
  for (int dy = -1; dy <= 1; ++dy)
    for (int dx = -1; dx <= 1; ++dx)
    {
      const Vector2i there = here + Vector2i(dx, dy), inside = there - low_;
      if ((dx == 0 && dy == 0) || (inside.array() < 0).any() ||
          (inside.array() >= size_.array()).any())
        continue;
      visit(index(there));
    }
}

bool Search::isFree(std::int32_t i)
{
  Node& node = at(i);
  if (node.free >= 0) return node.free == 1;
  const Vector2d here = point(i);
  const std::optional<Vector2d> there = plane_.freeNear(here, 0.75 * spacing_);
  node.free = there ? 1 : 0;
  if (!there) return false;
  node.dx = static_cast<float>(there->x() - here.x());
  node.dy = static_cast<float>(there->y() - here.y());
  return true;
}

/// The parent that really sees the node. False if there is none.
bool Search::settle(std::int32_t i)
{
  Node& node = at(i);
  node.closed = true;
  if (node.parent == i || plane_.seen(point(node.parent), point(i))) return true;
  node.cost = std::numeric_limits<double>::infinity();
  forNeighbours(i,
                [&](std::int32_t n)
                {
                  const double cost = at(n).cost + (point(n) - point(i)).norm();
                  if (!at(n).closed || !(cost < node.cost) || !plane_.seen(point(n), point(i)))
                    return;
                  node.cost = cost;
                  node.parent = n;
                });
  node.closed = std::isfinite(node.cost);  // else: its turn may come again, from elsewhere
  return node.closed;
}

void Search::open(std::int32_t i, std::int32_t parent, double cost)
{
  at(i).cost = cost;
  at(i).parent = parent;
  open_.emplace(cost + (point(i) - goal_).norm(), i);
}

std::vector<Vector2d> Search::run()
{
  const auto steps = static_cast<int>(std::lround(plane_.length / spacing_));
  const std::int32_t start = index({0, 0}), goal = index({steps, 0});
  goal_ = point(goal);
  if (plane_.room(point(start)) < 0.0 || plane_.room(goal_) < 0.0) return {};
  at(start).free = at(goal).free = 1;
  open(start, start, 0.0);
  while (!open_.empty())
  {
    const std::int32_t i = open_.top().second;
    open_.pop();
    if (at(i).closed || !settle(i)) continue;
    if (i == goal) break;
    const std::int32_t from = at(i).parent;
    forNeighbours(i,
                  [&](std::int32_t n)
                  {
                    if (at(n).closed || !isFree(n)) return;
                    const double cost = at(from).cost + (point(n) - point(from)).norm();
                    if (cost < at(n).cost) open(n, from, cost);
                  });
  }
  if (!at(goal).closed || !std::isfinite(at(goal).cost)) return {};
  std::vector<Vector2d> path{point(goal)};
  for (std::int32_t i = goal; at(i).parent != i; i = at(i).parent)
    path.push_back(point(at(i).parent));
  std::reverse(path.begin(), path.end());
  return path;
}

double nodesOf(const Plane& plane)
{
  return (plane.bounds().sizes() / kSpacing).prod();
}

double lengthOf(const std::vector<Vector2d>& path)
{
  double length = 0.0;
  for (std::size_t k = 1; k < path.size(); ++k) length += (path[k] - path[k - 1]).norm();
  return length;
}

/// Leaves out corners that are not needed.
void skipCorners(const Plane& plane, std::vector<Vector2d>& path)
{
  std::vector<Vector2d> kept{path.front()};
  for (std::size_t k = 1; k + 1 < path.size(); ++k)
    if (!plane.seen(kept.back(), path[k + 1])) kept.push_back(path[k]);
  kept.push_back(path.back());
  path = std::move(kept);
}

/// Cuts each corner as deep as there is room.
void cutCorners(const Plane& plane, std::vector<Vector2d>& path)
{
  constexpr double kLeast = 2e-3;  // [m]
  std::vector<Vector2d> cut{path.front()};
  for (std::size_t k = 1; k + 1 < path.size(); ++k)
  {
    const Vector2d back = cut.back() - path[k], on = path[k + 1] - path[k];
    double depth = std::min(back.norm(), on.norm());
    Vector2d a, b;
    do {
      depth *= 0.5;
      a = path[k] + depth * back.normalized();
      b = path[k] + depth * on.normalized();
    } while (depth > kLeast && !plane.seen(a, b));
    if (depth > kLeast)
    {
      cut.push_back(a);
      cut.push_back(b);
    }
    else
      cut.push_back(path[k]);
  }
  cut.push_back(path.back());
  path = std::move(cut);
}

void pullTight(const Plane& plane, std::vector<Vector2d>& path)
{
  constexpr double kGain = 1e-5;  // [1] of the length
  constexpr int kRounds = 200;
  double before = std::numeric_limits<double>::infinity();
  for (int round = 0; round < kRounds; ++round)
  {
    const double now = lengthOf(path);
    if (before - now < kGain * now) return;
    before = now;
    skipCorners(plane, path);
    cutCorners(plane, path);
  }
}
}  // namespace

std::optional<Eigen::Matrix3Xd> shortestRoute(const World& world, const Vector3d& start_W,
                                              const Vector3d& goal_W, double radius)
{
  const Plane plane(world, start_W, goal_W, radius);
  std::vector<Vector2d> path;
  if (plane.length < kStride)
  {
    if (plane.room({0.0, 0.0}) >= 0.0) path = {{0.0, 0.0}, {plane.length, 0.0}};
  }
  else if (plane.seen({0.0, 0.0}, {plane.length, 0.0}))
    path = {{0.0, 0.0}, {plane.length, 0.0}};
  else if (nodesOf(plane) <= kMostNodes)
    path = Search(plane).run();
  if (path.empty()) return std::nullopt;
  pullTight(plane, path);
  Eigen::Matrix3Xd route(3, static_cast<Eigen::Index>(path.size()));
  for (std::size_t k = 0; k < path.size(); ++k)
    route.col(static_cast<Eigen::Index>(k)) = plane.inWorld(path[k]);
  return route;
}

std::optional<double> shortestPath(const World& world, const Vector3d& start_W,
                                   const Vector3d& goal_W, double radius)
{
  const std::optional<Eigen::Matrix3Xd> route = shortestRoute(world, start_W, goal_W, radius);
  if (!route) return std::nullopt;
  const Eigen::Index legs = route->cols() - 1;
  return (route->rightCols(legs) - route->leftCols(legs)).colwise().norm().sum();
}

}  // namespace slalom::simulation
