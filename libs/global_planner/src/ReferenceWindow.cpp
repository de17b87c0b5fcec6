// SPDX-License-Identifier: BSD-3-Clause
#include "ReferenceWindow.h"

#include <algorithm>

namespace slalom::global_planner
{
double optimisticDistance(const core::DistanceField& field, const Eigen::Vector3d& p_L)
{
  return field.distance(p_L, core::UnknownAs::Free).value_or(field.maxDistance());
}

ReferenceWindow chooseWindow(const spline::UniformBSpline& r, double progress, double horizon_m,
                             const core::DistanceField& field, double free_distance)
{
  constexpr int kRoomToComeBack = 4;  // knots
  const Eigen::AlignedBox3d inside(field.bounds().min().array() + field.resolution(),
                                   field.bounds().max().array() - field.resolution());
  const auto knot = [&](Eigen::Index k) { return r.start() + r.knotSpan() * double(k); };
  ReferenceWindow window;
  window.first_knot = r.spanAt(progress);
  Eigen::Index at = window.first_knot, last_free = at;
  double length = 0.0;
  bool free = true;
  int free_run = 0;
  for (;;)
  {
    free = optimisticDistance(field, r.position(knot(at))) >= free_distance;
    free_run = free ? free_run + 1 : 0;
    if (free) last_free = at;
    if ((length >= horizon_m && free_run >= kRoomToComeBack) || at >= r.spans()) break;
    const Eigen::Vector3d next = r.position(knot(at + 1));
    if (!inside.contains(next)) break;
    length += (next - r.position(knot(at))).norm();
    ++at;
  }
  window.goal_blocked = !free && at >= r.spans();
  window.last_knot = free ? at : last_free;
  window.from = knot(window.first_knot);
  window.to = knot(window.last_knot);
  return window;
}

}  // namespace slalom::global_planner
