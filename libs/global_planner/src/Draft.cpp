// SPDX-License-Identifier: BSD-3-Clause
#include "Draft.h"

#include <algorithm>
#include <cmath>

namespace slalom::global_planner
{
namespace
{
using spline::UniformBSpline;

constexpr double kRoomToStop_s = 3.0;
constexpr double kPast_s = 1.0;  // kept behind the vehicle, so that its lag can be measured

double standsFor(const UniformBSpline& r, Eigen::Index point)
{
  return r.start() + r.knotSpan() * static_cast<double>(point - 1);
}

/// Appends R's control points `from` .. `to`.
void appendReference(Draft& draft, const UniformBSpline& r, Eigen::Index from, Eigen::Index to)
{
  const Eigen::Index count = to - from + 1, before = draft.points.cols();
  if (count <= 0) return;
  draft.points.conservativeResize(Eigen::NoChange, before + count);
  draft.along.conservativeResize(before + count);
  for (Eigen::Index k = 0; k < count; ++k)
  {
    draft.points.col(before + k) = r.controlPoints().col(from + k);
    draft.along[before + k] = standsFor(r, from + k);
  }
}

Eigen::Index firstKept(Eigen::Index span, double knot_span)
{
  return std::max<Eigen::Index>(0,
                                span - static_cast<Eigen::Index>(std::ceil(kPast_s / knot_span)));
}

}  // namespace

void Draft::replace(Eigen::Index first, Eigen::Index last, const Eigen::Matrix3Xd& points_L,
                    const Eigen::VectorXd& stand_for)
{
  const Eigen::Index added = points_L.cols(), behind = points.cols() - last;
  Eigen::Matrix3Xd all(3, first + added + behind);
  all << points.leftCols(first), points_L, points.rightCols(behind);
  Eigen::VectorXd stands(all.cols());
  stands << along.head(first), stand_for, along.tail(behind);
  points = std::move(all);
  along = std::move(stands);
}

void Draft::restAt(const Eigen::Vector3d& rest_L, PlanEnd why)
{
  const double last = along.size() > 0 ? along[along.size() - 1] : 0.0;
  replace(points.cols(), points.cols(), rest_L.replicate(1, kFixedAtEnd),
          Eigen::VectorXd::Constant(kFixedAtEnd, last));
  end = why;
}

Draft draftOfReference(const UniformBSpline& r, double progress, const ReferenceWindow& window)
{
  Draft draft;
  draft.knot_span = r.knotSpan();
  const Eigen::Index span = r.spanAt(progress), first = firstKept(span, r.knotSpan());
  draft.start = r.start() + r.knotSpan() * static_cast<double>(first);
  draft.points.resize(3, 0);
  appendReference(draft, r, first, std::max(window.lastPoint(), span + 3));
  draft.fixed = span - first + 4;
  return draft;
}

Draft draftOfPlan(const RefinedReference& plan, double progress, const UniformBSpline& r,
                  const ReferenceWindow& window)
{
  const UniformBSpline& curve = plan.spline;
  const Eigen::Index span = curve.spanAt(progress), first = firstKept(span, r.knotSpan());
  Draft draft;
  draft.knot_span = r.knotSpan();
  draft.start = curve.start() + curve.knotSpan() * static_cast<double>(first);
  draft.points = curve.controlPoints().rightCols(curve.size() - first);
  draft.along = plan.along.tail(plan.along.size() - first);
  draft.fixed = span - first + 4;
  draft.end = plan.end;
  if (draft.end != PlanEnd::OnReference) return draft;

  // The end of the window may have moved on, or back before something newly seen.
  const double window_end = standsFor(r, window.lastPoint() - 2) - 0.5 * r.knotSpan();
  Eigen::Index kept = draft.points.cols();
  while (kept > draft.fixed && draft.along[kept - 1] >= window_end) --kept;
  // A plan that was proved is not cut off under the vehicle: it keeps its own end until that fails.
  const auto room = static_cast<Eigen::Index>(std::ceil(kRoomToStop_s / r.knotSpan()));
  if (kept < draft.points.cols() && kept < draft.fixed + room) return draft;
  draft.points.conservativeResize(Eigen::NoChange, kept);
  draft.along.conservativeResize(kept);
  const double next = (draft.along[kept - 1] - r.start()) / r.knotSpan() + 1.0;
  appendReference(draft, r, static_cast<Eigen::Index>(std::floor(next + 0.5)) + 1,
                  window.lastPoint());
  return draft;
}

Draft draftBackToReference(const Draft& begin, const UniformBSpline& r, Eigen::Index join,
                           const ReferenceWindow& window)
{
  Draft draft = begin;
  draft.points = begin.points.leftCols(begin.fixed);
  draft.along = begin.along.head(begin.fixed);
  draft.end = PlanEnd::OnReference;
  appendReference(draft, r, join, window.lastPoint());
  for (Eigen::Index i = draft.fixed; i < draft.along.size(); ++i)
    draft.along[i] = std::max(draft.along[i], draft.along[i - 1]);
  return draft;
}

Draft draftAtVehicle(const core::VehicleState& state, double progress, double along,
                     double knot_span)
{
  Draft draft;
  draft.start = progress;
  draft.knot_span = knot_span;
  draft.points.resize(3, draft.fixed);
  for (Eigen::Index i = 0; i < draft.fixed; ++i)
    draft.points.col(i) = state.p_L + state.v_W * (knot_span * static_cast<double>(i - 1));
  draft.along = Eigen::VectorXd::Constant(draft.fixed, along);
  return draft;
}

Eigen::Matrix3Xd referencePoints(const UniformBSpline& r, const Eigen::VectorXd& along)
{
  Eigen::Matrix3Xd points(3, along.size());
  for (Eigen::Index i = 0; i < along.size(); ++i)
  {
    const double at = std::clamp((along[i] - r.start()) / r.knotSpan() + 1.0, 0.0,
                                 static_cast<double>(r.size() - 1));
    const auto k = std::min<Eigen::Index>(static_cast<Eigen::Index>(at), r.size() - 2);
    const double u = at - static_cast<double>(k);
    points.col(i) = (1.0 - u) * r.controlPoints().col(k) + u * r.controlPoints().col(k + 1);
  }
  return points;
}

}  // namespace slalom::global_planner
