// SPDX-License-Identifier: BSD-3-Clause
#include "ReferenceClock.h"

#include <algorithm>
#include <cmath>

namespace slalom::engine
{
namespace
{
/// Largest share of the curve's own pace at which no axis exceeds its limits between `from` and
/// `to`: velocity grows with the pace, acceleration with its square.
double paceLimit(const spline::UniformBSpline& curve, double from, double to,
                 const core::Vehicle& vehicle)
{
  double pace = 1.0;
  for (double t = from; t <= to; t += 0.5 * curve.knotSpan())
  {
    const double speed = curve.velocity(t).cwiseAbs().maxCoeff();
    const double acceleration = curve.acceleration(t).cwiseAbs().maxCoeff();
    if (speed > 0.0) pace = std::min(pace, vehicle.max_speed_mps / speed);
    if (acceleration > 0.0)
      pace = std::min(pace, std::sqrt(vehicle.max_acceleration_mps2 / acceleration));
  }
  return pace;
}

}  // namespace

void ReferenceClock::advance(double dt, const spline::UniformBSpline& curve,
                             const Eigen::Vector3d& p_L, double stop_at,
                             const core::Vehicle& vehicle)
{
  constexpr double kBack_s = 1.0, kAhead_s = 4.0, kPreview_s = 1.5;
  const double back = std::max(curve.start(), progress_ - kBack_s);
  double nearest = curve.project(p_L, back, std::min(curve.end(), progress_ + kAhead_s));
  // A vehicle that is taken along another way (wind, a pilot, a recording) is met again farther on.
  constexpr double kLost_m = 2.0;
  const auto distanceAt = [&](double t) { return (curve.position(t) - p_L).norm(); };
  if (distanceAt(nearest) > kLost_m)
    if (const double farther = curve.project(p_L, back, curve.end());
        distanceAt(farther) < 0.5 * distanceAt(nearest))
      nearest = farther;
  rate_ = paceLimit(curve, progress_, std::min(curve.end(), progress_ + kPreview_s), vehicle);
  const double wanted = std::clamp(progress_ + rate_ * dt, nearest, nearest + max_lead_s_);
  progress_ = std::max(progress_, std::min(wanted, std::max(stop_at, curve.start())));
}

}  // namespace slalom::engine
