// SPDX-License-Identifier: BSD-3-Clause
#include "Describe.h"

#include <algorithm>
#include <utility>

namespace slalom::engine
{
namespace
{
Eigen::Matrix3Xd samplePath(const spline::UniformBSpline& curve, double from, double to,
                            double step_s)
{
  return curve.sample(from, to, std::max<Eigen::Index>(2, Eigen::Index((to - from) / step_s) + 1));
}
}  // namespace

void describePlan(const local_planner::LocalPlannerInput& input, double ahead_s,
                  core::CycleRecord& record)
{
  const double end = std::min(input.reference->end(), input.progress + ahead_s);
  record.refined = samplePath(*input.reference, input.progress, end, 0.1);
  record.committed = samplePath(*input.reference, input.progress, input.law->to(), 0.1);
}

void describeStep(local_planner::LocalPlannerOutput& output, core::CycleRecord& record)
{
  record.horizon = std::move(output.horizon_L);
  record.horizon_yaw = std::move(output.horizon_yaw);
  record.nmpc = std::move(output.report);
  if (output.fallback != local_planner::Fallback::None) record.fallback = toString(output.fallback);
  if (record.horizon.cols() > 1)
  {
    record.setpoint_L = record.horizon.col(1);
    record.setpoint_yaw = record.horizon_yaw[1];
  }
}

void describeMission(const Flight& flight, const Refinements& refinements, double on_reference,
                     core::CycleRecord& record)
{
  const spline::UniformBSpline& r = *flight.reference_L;
  constexpr double kStep_s = 0.2, kMostPoints = 5000.0;
  record.reference =
      samplePath(r, r.start(), r.end(), std::max(kStep_s, r.duration() / kMostPoints));
  record.progress_s = on_reference;
  record.reference_point_L = r.position(on_reference);
  record.distance_to_goal_m = (record.state.p_L - r.position(r.end())).norm();
  const bool ran = record.refinement.ran;
  record.refinement = refinements.explanation();
  record.refinement.ran = ran;
  record.refinement.goal = toString(refinements.goal().state);
  record.refinement.goal_short_m = refinements.goal().short_m;
}

}  // namespace slalom::engine
