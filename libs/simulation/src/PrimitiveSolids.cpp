// SPDX-License-Identifier: BSD-3-Clause
#include "PrimitiveSolids.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace slalom::simulation::detail
{
namespace
{
constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kMaxCells = 4e6;
}  // namespace

struct PrimitiveSolids::Ray
{
  Eigen::Vector3d origin, direction;
  double a;  // squared length of the horizontal part
};

PrimitiveSolids::PrimitiveSolids(std::vector<Tree> trees, std::vector<Box> boxes,
                                 std::vector<Sphere> spheres)
    : trees_(std::move(trees)), boxes_(std::move(boxes)), spheres_(std::move(spheres))
{
  for (const Tree& tree : trees_)
  {
    const Eigen::Vector2d r(tree.radius, tree.radius);
    const Eigen::Vector2d lo = tree.centre_W - r, hi = tree.centre_W + r;
    bounds_.extend(Eigen::Vector3d(lo.x(), lo.y(), tree.base));
    bounds_.extend(Eigen::Vector3d(hi.x(), hi.y(), tree.base + tree.height));
  }
  for (const Box& box : boxes_) bounds_.extend(box);
  for (const Sphere& sphere : spheres_)
  {
    bounds_.extend((sphere.centre_W.array() - sphere.radius).matrix());
    bounds_.extend((sphere.centre_W.array() + sphere.radius).matrix());
  }
  if (!bounds_.isEmpty()) buildGrid();
}

Eigen::AlignedBox2d PrimitiveSolids::footprint(std::size_t shape) const
{
  if (shape < trees_.size())
  {
    const Eigen::Vector2d r = Eigen::Vector2d::Constant(trees_[shape].radius);
    return {trees_[shape].centre_W - r, trees_[shape].centre_W + r};
  }
  const std::size_t rest = shape - trees_.size();
  if (rest < boxes_.size()) return {boxes_[rest].min().head<2>(), boxes_[rest].max().head<2>()};
  const Sphere& sphere = spheres_[rest - boxes_.size()];
  const Eigen::Vector2d r = Eigen::Vector2d::Constant(sphere.radius);
  return {sphere.centre_W.head<2>() - r, sphere.centre_W.head<2>() + r};
}

int PrimitiveSolids::clampedX(double x) const
{
  return static_cast<int>(std::clamp((x - bounds_.min().x()) / edge_, 0.0, size_x_ - 1.0));
}

int PrimitiveSolids::clampedY(double y) const
{
  return static_cast<int>(std::clamp((y - bounds_.min().y()) / edge_, 0.0, size_y_ - 1.0));
}

void PrimitiveSolids::buildGrid()
{
  const Eigen::Vector2d extent = bounds_.sizes().head<2>();
  const double area = extent.x() * extent.y();
  // About one shape per cell: a ray then pays as much for cells as for shapes.
  edge_ = std::clamp(std::sqrt(area / double(shapes())), 1.0, 4.0);
  edge_ = std::max(edge_, std::sqrt(area / kMaxCells));
  size_x_ = static_cast<int>(extent.x() / edge_) + 1;
  size_y_ = static_cast<int>(extent.y() / edge_) + 1;
  const std::size_t cells = cell(0, size_y_);
  const auto forEachCell = [&](std::size_t shape, auto&& visit)
  {
    const Eigen::AlignedBox2d foot = footprint(shape);
    for (int y = clampedY(foot.min().y()); y <= clampedY(foot.max().y()); ++y)
      for (int x = clampedX(foot.min().x()); x <= clampedX(foot.max().x()); ++x) visit(cell(x, y));
  };
  first_.assign(cells + 1, 0);
  for (std::size_t s = 0; s < shapes(); ++s)
    forEachCell(s, [&](std::size_t c) { ++first_[c + 1]; });
  for (std::size_t c = 0; c < cells; ++c) first_[c + 1] += first_[c];
  shapes_.resize(first_.back());
  std::vector<std::uint32_t> next(first_.begin(), first_.end() - 1);
  for (std::size_t s = 0; s < shapes(); ++s)
    forEachCell(s, [&](std::size_t c) { shapes_[next[c]++] = static_cast<std::uint32_t>(s); });
}

/// Where the ray enters the shape if that is nearer than `best`, else `best`.
double PrimitiveSolids::hit(std::size_t shape, const Ray& ray, double best) const
{
  Interval inside{0.0, best};
  if (shape >= trees_.size() + boxes_.size())
  {
    const Sphere& sphere = spheres_[shape - trees_.size() - boxes_.size()];
    return std::min(best, hitSphere(ray.origin - sphere.centre_W, ray.direction, sphere.radius));
  }
  if (shape >= trees_.size())
  {
    const Box& box = boxes_[shape - trees_.size()];
    for (int i = 0; i < 3; ++i)
      inside = slab(ray.origin[i], ray.direction[i], box.min()[i], box.max()[i], inside);
    return inside.enter <= inside.leave ? inside.enter : best;
  }
  const Tree& tree = trees_[shape];
  const Eigen::Vector3d foot(tree.centre_W.x(), tree.centre_W.y(), tree.base);
  return std::min(best, hitCylinder(ray.origin - foot, ray.direction, tree.radius, tree.height));
}

std::optional<double> PrimitiveSolids::castRay(const Eigen::Vector3d& origin,
                                               const Eigen::Vector3d& direction,
                                               double max_range) const
{
  if (first_.empty()) return std::nullopt;
  Interval inside{0.0, max_range};
  for (int i = 0; i < 3; ++i)
    inside = slab(origin[i], direction[i], bounds_.min()[i], bounds_.max()[i], inside);
  if (inside.enter > inside.leave) return std::nullopt;

  const Ray ray{origin, direction, direction.head<2>().squaredNorm()};
  const Eigen::Vector3d start = origin + inside.enter * direction;
  int index[2] = {clampedX(start.x()), clampedY(start.y())};
  int step[2], end[2];
  double next[2], delta[2];
  const int size[2] = {size_x_, size_y_};
  for (int i = 0; i < 2; ++i)
  {
    const double d = direction[i];
    step[i] = d > 0.0 ? 1 : -1;
    end[i] = d > 0.0 ? size[i] : -1;
    const double border = bounds_.min()[i] + edge_ * (index[i] + (d > 0.0 ? 1 : 0));
    next[i] = d == 0.0 ? kInfinity : (border - origin[i]) / d;
    delta[i] = d == 0.0 ? kInfinity : edge_ / std::abs(d);
  }
  // `best` starts a little beyond the range, so that "nothing" and "hit at max_range" differ.
  const double nothing = std::nextafter(max_range, kInfinity);
  double best = nothing;
  while (true)
  {
    const std::size_t c = cell(index[0], index[1]);
    for (std::uint32_t k = first_[c]; k < first_[c + 1]; ++k) best = hit(shapes_[k], ray, best);
    const int axis = next[0] < next[1] ? 0 : 1;
    // A hit beyond this cell may be beaten by a shape of the next one.
    if (best <= next[axis] || next[axis] > inside.leave) break;
    index[axis] += step[axis];
    if (index[axis] == end[axis]) break;
    next[axis] += delta[axis];
  }
  if (best >= nothing) return std::nullopt;
  return best;
}

double PrimitiveSolids::shapeDistance(std::size_t shape, const Eigen::Vector3d& p) const
{
  if (shape < trees_.size())
  {
    const Tree& tree = trees_[shape];
    return cylinderDistance(p - Eigen::Vector3d(tree.centre_W.x(), tree.centre_W.y(), tree.base),
                            tree.radius, tree.height);
  }
  if (shape >= trees_.size() + boxes_.size())
  {
    const Sphere& sphere = spheres_[shape - trees_.size() - boxes_.size()];
    return (p - sphere.centre_W).norm() - sphere.radius;
  }
  const Box& box = boxes_[shape - trees_.size()];
  const Eigen::Vector3d out = (box.min() - p).cwiseMax(p - box.max());
  const double deepest = out.maxCoeff();
  return deepest <= 0.0 ? deepest : out.cwiseMax(0.0).norm();
}

double PrimitiveSolids::nearestInCell(int x, int y, const Eigen::Vector3d& p, double best) const
{
  if (x < 0 || y < 0 || x >= size_x_ || y >= size_y_) return best;
  const std::size_t c = cell(x, y);
  for (std::uint32_t k = first_[c]; k < first_[c + 1]; ++k)
    best = std::min(best, shapeDistance(shapes_[k], p));
  return best;
}

double PrimitiveSolids::distance(const Eigen::Vector3d& p) const
{
  if (first_.empty()) return kInfinity;
  const int cx = clampedX(p.x()), cy = clampedY(p.y());
  // Nearest point of the grid to p: everything in the grid is at least as far from p as from it.
  const double qx = std::clamp(p.x(), bounds_.min().x(), bounds_.min().x() + edge_ * size_x_);
  const double qy = std::clamp(p.y(), bounds_.min().y(), bounds_.min().y() + edge_ * size_y_);
  const double x0 = bounds_.min().x() + edge_ * cx, y0 = bounds_.min().y() + edge_ * cy;
  const double to_border = std::min({qx - x0, x0 + edge_ - qx, qy - y0, y0 + edge_ - qy});

  double best = nearestInCell(cx, cy, p, kInfinity);
  const int rings = std::max({cx, size_x_ - 1 - cx, cy, size_y_ - 1 - cy});
  for (int r = 1; r <= rings; ++r)
  {
    // Shapes met first in ring r lie wholly outside the rings within it.
    if (best <= to_border + edge_ * (r - 1)) break;
    for (int i = -r; i <= r; ++i)
    {
      best = nearestInCell(cx + i, cy - r, p, best);
      best = nearestInCell(cx + i, cy + r, p, best);
    }
    for (int i = -r + 1; i < r; ++i)
    {
      best = nearestInCell(cx - r, cy + i, p, best);
      best = nearestInCell(cx + r, cy + i, p, best);
    }
  }
  return best;
}

}  // namespace slalom::simulation::detail
