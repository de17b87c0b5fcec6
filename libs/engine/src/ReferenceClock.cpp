// SPDX-License-Identifier: BSD-3-Clause
#include "ReferenceClock.h"

#include <algorithm>
#include <limits>

namespace slalom::engine
{
namespace
{
/** Where on the curve the vehicle is. In a hook whose other branch it cut to, that is not the
 * nearest point of all: the clock would wait for the vehicle on one branch, and the vehicle for the
 * clock on the other. So a second apart from `progress` counts like half a metre (from where on a
 * standing vehicle gets a new plan), but only to tell the branches apart. */
double placeOf(const Eigen::Vector3d& p_L, const spline::UniformBSpline& curve, double progress,
               double from, double to)
{
  constexpr double kStep_s = 0.05, kBranch_s = 0.3, kApart_mps = 0.5;
  double place = from, least = std::numeric_limits<double>::infinity();
  for (double t = from; t <= to; t += kStep_s)
  {
    const double apart = kApart_mps * (t - progress);
    const double cost = (curve.position(t) - p_L).squaredNorm() + apart * apart;
    if (cost >= least) continue;
    least = cost;
    place = t;
  }
  return curve.project(p_L, std::max(from, place - kBranch_s), std::min(to, place + kBranch_s));
}
}  // namespace

void ReferenceClock::advance(double dt, const spline::UniformBSpline& curve,
                             const spline::TimeLaw& law, const Eigen::Vector3d& p_L)
{
  constexpr double kBack_s = 1.0;
  const double from = std::max(curve.start(), progress_ - kBack_s);
  const double to = std::min(curve.end(), progress_ + ahead_s_);
  const double nearest =
      open_loop_ ? curve.project(p_L, from, to) : placeOf(p_L, curve, progress_, from, to);
  const double wanted =
      std::clamp(law.advance(std::max(progress_, law.from()), dt), nearest, nearest + max_lead_s_);
  progress_ = std::max(progress_, std::min(wanted, law.to()));
  pace_ = law.pace(progress_);
}

}  // namespace slalom::engine
