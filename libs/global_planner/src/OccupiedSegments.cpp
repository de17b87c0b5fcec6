// SPDX-License-Identifier: BSD-3-Clause
#include "slalom/global_planner/OccupiedSegments.h"

#include <algorithm>
#include <cmath>

#include "ReferenceWindow.h"

namespace slalom::global_planner
{
namespace
{
/// Largest speed of the curve, from its derivative control points [m/s].
double speedBound(const spline::UniformBSpline& curve, double from, double to)
{
  const Eigen::Matrix3Xd velocities = curve.velocityControlPoints();
  const Eigen::Index first = curve.spanAt(from), last = curve.spanAt(to) + 2;
  return velocities.middleCols(first, last - first + 1).colwise().norm().maxCoeff();
}

/// Time between samples such that none is farther than half a voxel from the next [s].
double sampleStep(const spline::UniformBSpline& curve, double from, double to,
                  const core::DistanceField& field)
{
  return 0.5 * field.resolution() / std::max(speedBound(curve, from, to), 1e-3);
}

}  // namespace

std::vector<OccupiedSegment> findOccupiedSegments(const spline::UniformBSpline& curve, double from,
                                                  double to, const core::DistanceField& field,
                                                  double clearance, double merge_gap)
{
  std::vector<OccupiedSegment> segments;
  if (to <= from) return segments;
  const double step = sampleStep(curve, from, to, field);
  const double speed = 0.5 * field.resolution() / step;
  bool inside = false;
  double last_free = from;
  for (double t = from;;)
  {
    const double distance = optimisticDistance(field, curve.position(t));
    const bool occupied = distance < clearance;
    if (occupied && !inside)
      segments.push_back({last_free, to, t == from, true});
    else if (!occupied && inside)
    {
      segments.back().to = t;
      segments.back().open_end = false;
    }
    inside = occupied;
    if (!occupied) last_free = t;
    if (t >= to) break;
    // Inside free space the curve cannot reach an obstacle before it has flown the spare distance.
    const double leap = occupied ? 0.0 : 0.7 * (distance - clearance) / speed;
    t = std::min(to, t + std::max(step, leap));
  }

  std::vector<OccupiedSegment> merged;
  for (const OccupiedSegment& segment : segments)
  {
    if (!merged.empty() && segment.from - merged.back().to < merge_gap)
    {
      merged.back().to = segment.to;
      merged.back().open_end = segment.open_end;
    }
    else
      merged.push_back(segment);
  }
  return merged;
}

double minClearance(const spline::UniformBSpline& curve, double from, double to,
                    const core::DistanceField& field)
{
  double nearest = field.maxDistance();
  const double step = sampleStep(curve, from, to, field);
  for (double t = from; t < to + step; t += step)
    nearest = std::min(nearest, optimisticDistance(field, curve.position(std::min(t, to))));
  return nearest;
}

}  // namespace slalom::global_planner
