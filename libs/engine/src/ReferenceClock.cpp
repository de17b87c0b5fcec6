// SPDX-License-Identifier: BSD-3-Clause
#include "ReferenceClock.h"

#include <algorithm>

namespace slalom::engine
{
void ReferenceClock::advance(double dt, const spline::UniformBSpline& curve,
                             const spline::TimeLaw& law, const Eigen::Vector3d& p_L)
{
  constexpr double kBack_s = 1.0;
  const double nearest = curve.project(p_L, std::max(curve.start(), progress_ - kBack_s),
                                       std::min(curve.end(), progress_ + ahead_s_));
  const double wanted =
      std::clamp(law.advance(std::max(progress_, law.from()), dt), nearest, nearest + max_lead_s_);
  progress_ = std::max(progress_, std::min(wanted, law.to()));
  pace_ = law.pace(progress_);
}

}  // namespace slalom::engine
