// SPDX-License-Identifier: BSD-3-Clause
#include "FreeSpace.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace slalom::geometry::detail
{
namespace
{
constexpr double kSmallest = 1e-6;   ///< [m] a point nearer to the segment is on it
constexpr double kTolerance = 1e-9;  ///< [m] rounding allowed when a plane touches an end

Eigen::Matrix3d axesAlong(const Eigen::Vector3d& direction)
{
  // A vertical segment has no horizontal side of its own; the x axis then is as good as any.
  const Eigen::Vector3d up =
      std::abs(direction.z()) < 0.999 ? Eigen::Vector3d::UnitZ() : Eigen::Vector3d::UnitX();
  Eigen::Matrix3d axes;
  axes.col(0) = direction;
  axes.col(1) = up.cross(direction).normalized();
  axes.col(2) = direction.cross(axes.col(1));
  return axes;
}

void cropToBox(const std::vector<Eigen::Vector3d>& obstacles_L, const SegmentFrame& frame,
               double margin, Scratch& s)
{
  const Eigen::Matrix3d to_frame = frame.axes.transpose();
  const Eigen::Vector3d reach = frame.half_box.array() + margin;
  s.count = 0;
  for (const Eigen::Vector3d& obstacle : obstacles_L)
  {
    const Eigen::Vector3d p = to_frame * (obstacle - frame.middle);
    // A point that is not finite compares false and is dropped here.
    if (!(std::abs(p.x()) <= reach.x() && std::abs(p.y()) <= reach.y() &&
          std::abs(p.z()) <= reach.z()))
      continue;
    if (s.count == s.x.size())
      for (auto* array : {&s.x, &s.y, &s.z, &s.metric}) array->resize(2 * s.count + 1024);
    s.x[s.count] = p.x();
    s.y[s.count] = p.y();
    s.z[s.count] = p.z();
    ++s.count;
  }
}

struct Ellipsoid
{
  Eigen::Vector3d semi;       ///< [m] axes: along the segment, towards the nearest obstacle, third
  double roll_cos, roll_sin;  ///< of the second axis about the segment
};

/// Index of the obstacle that a spheroid about the segment, shrunk until none is inside, touches;
/// `count` if there is none in the sphere. Shrinking to the closest point again and again ends at
/// the smallest ratio, so one pass over the points finds it.
std::size_t touchingObstacle(double f, const Scratch& s, double& semi2)
{
  const double per_f2 = 1.0 / (f * f);
  std::size_t touching = s.count;
  semi2 = f * f;
  for (std::size_t i = 0; i < s.count; ++i)
  {
    const double height = 1.0 - s.x[i] * s.x[i] * per_f2;
    const double radius2 = s.y[i] * s.y[i] + s.z[i] * s.z[i];
    if (height <= 0.0 || radius2 >= semi2 * height) continue;
    semi2 = radius2 / height;
    touching = i;
  }
  return touching;
}

/// The spheroid, then the largest third axis. Turns the obstacles about the segment into the axes
/// of the ellipsoid.
Ellipsoid inflate(double half_length, Scratch& s)
{
  const double f = std::max(half_length, kSmallest);
  double semi2 = 0.0;
  const std::size_t touching = touchingObstacle(f, s, semi2);
  Ellipsoid e{{f, f, f}, 1.0, 0.0};
  if (touching == s.count) return e;
  const double b = std::max(std::sqrt(semi2), kSmallest);
  const double radius = std::hypot(s.y[touching], s.z[touching]);
  if (radius > kSmallest)
  {
    e.roll_cos = s.y[touching] / radius;
    e.roll_sin = s.z[touching] / radius;
  }

  double third = f * f;
  const double per_f2 = 1.0 / (f * f), per_b2 = 1.0 / (b * b);
  for (std::size_t i = 0; i < s.count; ++i)
  {
    const double y = e.roll_cos * s.y[i] + e.roll_sin * s.z[i];
    const double z = e.roll_cos * s.z[i] - e.roll_sin * s.y[i];
    s.y[i] = y;
    s.z[i] = z;
    const double height = 1.0 - s.x[i] * s.x[i] * per_f2 - y * y * per_b2;
    // The touching point itself has no height but for rounding.
    if (height > 1e-9 && z * z < third * height) third = z * z / height;
  }
  // No obstacle is inside the spheroid, so the third axis cannot be shorter but for rounding.
  e.semi = {f, b, std::clamp(std::sqrt(third), b, f)};
  return e;
}

/// Notes the ellipsoid metric of every obstacle; returns the index of the nearest.
std::size_t measure(const Ellipsoid& e, Scratch& s)
{
  const Eigen::Vector3d weight = e.semi.cwiseAbs2().cwiseInverse();
  double best = std::numeric_limits<double>::infinity();
  std::size_t nearest = 0;
  for (std::size_t i = 0; i < s.count; ++i)
  {
    const double metric =
        weight.x() * s.x[i] * s.x[i] + weight.y() * s.y[i] * s.y[i] + weight.z() * s.z[i] * s.z[i];
    s.metric[i] = metric;
    if (metric < best)
    {
      best = metric;
      nearest = i;
    }
  }
  return nearest;
}

/// Outward normal of the plane for obstacle `p`, in the ellipsoid's axes.
Eigen::Vector3d separatingNormal(const Eigen::Vector3d& p, const Ellipsoid& e, double half_length,
                                 double shrink)
{
  const Eigen::Vector3d tangent = (p.array() / e.semi.array().square()).matrix().stableNormalized();
  // Room between the plane and the nearer end, which has to hold the shrink.
  const double room = tangent.dot(p) - half_length * std::abs(tangent.x());
  if (tangent.squaredNorm() > 0.5 && room >= shrink && room >= 0.0) return tangent;
  // The plane across the shortest way from the segment has the most room that any plane can have.
  const Eigen::Vector3d away =
      p - Eigen::Vector3d(std::clamp(p.x(), -half_length, half_length), 0.0, 0.0);
  const double distance = away.norm();
  if (distance > kSmallest) return away / distance;
  return tangent.squaredNorm() > 0.5 ? tangent : Eigen::Vector3d(0.0, 1.0, 0.0);
}

/// Drops every obstacle on or behind the plane (give or take rounding at such distances from the
/// middle); returns the index of the nearest one left. Which points go is unpredictable, so every
/// point is written and the end advances only past those to keep: no branch can be mispredicted.
std::size_t dropBehind(const LocalPlane& plane, double reach, Scratch& s)
{
  const double nx = plane.normal.x(), ny = plane.normal.y(), nz = plane.normal.z();
  const double limit = plane.offset - 1e-12 * (1.0 + reach);
  double best = std::numeric_limits<double>::infinity();
  std::size_t kept = 0, nearest = 0;
  for (std::size_t i = 0; i < s.count; ++i)
  {
    const double x = s.x[i], y = s.y[i], z = s.z[i], metric = s.metric[i];
    s.x[kept] = x;
    s.y[kept] = y;
    s.z[kept] = z;
    s.metric[kept] = metric;
    const bool keep = nx * x + ny * y + nz * z < limit;
    const bool nearer = keep & (metric < best);
    best = nearer ? metric : best;
    nearest = nearer ? kept : nearest;
    kept += static_cast<std::size_t>(keep);
  }
  s.count = kept;
  return nearest;
}

void cutObstacles(const Ellipsoid& e, double half_length, double shrink, Scratch& s)
{
  s.planes.clear();
  std::size_t nearest = measure(e, s);
  while (s.count > 0)
  {
    const Eigen::Vector3d p(s.x[nearest], s.y[nearest], s.z[nearest]);
    const Eigen::Vector3d normal = separatingNormal(p, e, half_length, shrink);
    s.planes.push_back({normal, normal.dot(p)});
    nearest = dropBehind(s.planes.back(), p.lpNorm<1>(), s);
  }
}

/// Back to the segment's own axes, and moved inwards; planes that no longer cut the box are
/// dropped.
void finishPlanes(const Ellipsoid& e, const SegmentFrame& frame, double shrink, Scratch& s)
{
  for (LocalPlane& plane : s.planes)
  {
    const Eigen::Vector3d n = plane.normal;
    plane.normal.y() = e.roll_cos * n.y() - e.roll_sin * n.z();
    plane.normal.z() = e.roll_sin * n.y() + e.roll_cos * n.z();
    plane.offset -= shrink;
  }
  std::erase_if(s.planes, [&](const LocalPlane& plane)
                { return plane.normal.cwiseAbs().dot(frame.half_box) <= plane.offset; });
}

FreePolyhedron assemble(const SegmentFrame& frame, const Scratch& s)
{
  const auto cuts = static_cast<Eigen::Index>(s.planes.size());
  FreePolyhedron out;
  out.set.A.resize(cuts + 6, 3);
  out.set.b.resize(cuts + 6);
  bool holds = true;
  for (Eigen::Index i = 0; i < cuts; ++i)
  {
    const LocalPlane& plane = s.planes[static_cast<std::size_t>(i)];
    const Eigen::Vector3d normal_L = (frame.axes * plane.normal).normalized();
    out.set.A.row(i) = normal_L.transpose();
    out.set.b[i] = plane.offset + normal_L.dot(frame.middle);
    // The farther end is the one that the plane is nearest to.
    holds = holds && frame.half_length * std::abs(plane.normal.x()) <= plane.offset + kTolerance;
  }
  for (int axis = 0; axis < 3; ++axis)
    for (int side = 0; side < 2; ++side)
    {
      const Eigen::Vector3d normal_L = (side == 0 ? 1.0 : -1.0) * frame.axes.col(axis);
      const Eigen::Index row = cuts + 2 * axis + side;
      out.set.A.row(row) = normal_L.transpose();
      out.set.b[row] = normal_L.dot(frame.middle) + frame.half_box[axis];
    }
  out.contains_seed = holds;
  return out;
}
}  // namespace

SegmentFrame::SegmentFrame(const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                           const DecompositionConfig& config)
    : middle(0.5 * (a + b)), half_length(0.5 * (b - a).norm())
{
  axes = half_length > kSmallest ? axesAlong((b - a).normalized()) : Eigen::Matrix3d::Identity();
  half_box = {half_length + config.along_m, config.lateral_m, config.vertical_m};
}

FreePolyhedron freePolyhedron(const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                              const std::vector<Eigen::Vector3d>& obstacles_L,
                              const DecompositionConfig& config, Scratch& scratch)
{
  const SegmentFrame frame(a, b, config);
  // An obstacle just outside the box still takes its shrink from the inside.
  cropToBox(obstacles_L, frame, config.shrink_m, scratch);
  const Ellipsoid ellipsoid = inflate(frame.half_length, scratch);
  cutObstacles(ellipsoid, frame.half_length, config.shrink_m, scratch);
  finishPlanes(ellipsoid, frame, config.shrink_m, scratch);
  return assemble(frame, scratch);
}

}  // namespace slalom::geometry::detail
