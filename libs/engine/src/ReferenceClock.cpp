// SPDX-License-Identifier: BSD-3-Clause
#include "ReferenceClock.h"

#include <algorithm>

namespace slalom::engine
{
namespace
{
/// Largest share of the curve's own pace at which no axis exceeds the limit between `from` and
/// `to`.
double paceLimit(const spline::UniformBSpline& curve, double from, double to, double max_speed)
{
  double fastest = 0.0;
  for (double t = from; t <= to; t += 0.5 * curve.knotSpan())
    fastest = std::max(fastest, curve.velocity(t).cwiseAbs().maxCoeff());
  return std::min(1.0, max_speed / std::max(fastest, 1e-6));
}

}  // namespace

void ReferenceClock::advance(double dt, const spline::UniformBSpline& curve,
                             const Eigen::Vector3d& p_L, double stop_at,
                             const core::Vehicle& vehicle)
{
  constexpr double kBack_s = 1.0, kAhead_s = 4.0, kPreview_s = 1.5;
  const double nearest = curve.project(p_L, std::max(curve.start(), progress_ - kBack_s),
                                       std::min(curve.end(), progress_ + kAhead_s));
  rate_ = paceLimit(curve, progress_, std::min(curve.end(), progress_ + kPreview_s),
                    vehicle.max_speed_mps);
  const double wanted = std::clamp(progress_ + rate_ * dt, nearest, nearest + max_lead_s_);
  progress_ = std::max(progress_, std::min(wanted, std::max(stop_at, curve.start())));
}

}  // namespace slalom::engine
