// SPDX-License-Identifier: BSD-3-Clause
#include "PlanningWindow.h"

#include <algorithm>

namespace slalom::global_planner
{
double optimisticDistance(const core::DistanceField& field, const Eigen::Vector3d& p_L)
{
  return field.distance(p_L, core::UnknownAs::Free).value_or(field.maxDistance());
}

PlanningWindow choosePlanningWindow(const spline::UniformBSpline& r, double progress,
                                    double horizon_m, const core::DistanceField& field,
                                    double free_distance)
{
  const Eigen::AlignedBox3d inside(field.bounds().min().array() + field.resolution(),
                                   field.bounds().max().array() - field.resolution());
  PlanningWindow window;
  window.from = std::clamp(progress, r.start(), r.end());
  double to = window.from, length = 0.0, last_free = window.from;
  bool free = true;
  int free_run = 0;  // knots since R became free
  for (;;)
  {
    free = optimisticDistance(field, r.position(to)) >= free_distance;
    free_run = free ? free_run + 1 : 0;
    if (free) last_free = to;
    if ((length >= horizon_m && free_run > kFixedAtEnd) || to >= r.end()) break;
    const double next = std::min(to + r.knotSpan(), r.end());
    if (!inside.contains(r.position(next))) break;
    length += (r.position(next) - r.position(to)).norm();
    to = next;
  }
  window.blocked_end = !free;
  window.goal_blocked = !free && to >= r.end();
  window.to = free ? to : last_free;
  window.first = r.spanAt(window.from);
  window.count = r.spanAt(window.to) + spline::UniformBSpline::kDegree + 1 - window.first;
  return window;
}

}  // namespace slalom::global_planner
