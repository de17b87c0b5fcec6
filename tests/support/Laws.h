// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include "slalom/spline/TimeLaw.h"

namespace slalom::test
{
/// The curve at its own pace from its start to `to` [s], or at `speed_mps` per axis where that is
/// slower; stops practically at once.
[[nodiscard]] inline std::shared_ptr<const spline::TimeLaw> lawTo(
    const spline::UniformBSpline& curve, double to, double speed_mps = 1e3)
{
  const double fastest = curve.velocity(curve.start()).cwiseAbs().maxCoeff();
  const double pace = fastest > speed_mps ? speed_mps / fastest : 1.0;
  return std::make_shared<const spline::TimeLaw>(curve, curve.start(), to, pace,
                                                 spline::MotionLimits{speed_mps, 1e6});
}

}  // namespace slalom::test
