// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "slalom/spline/TimeLaw.h"
#include "slalom/spline/UniformBSpline.h"

namespace slalom::engine
{
/** Runs the parameter of the plan. It advances as the plan's time law says, but never farther than
 * `max_lead` ahead of the vehicle's own projection and never backwards, so a delayed vehicle does
 * not meet a runaway reference. A vehicle that gets ahead is followed, but not to a later part of
 * the curve that merely passes nearby; only a vehicle that nobody steers (`open_loop`) may cut
 * corners.
 * @see deviation D-10 (docs/paper_map.md) */
class ReferenceClock
{
 public:
  explicit ReferenceClock(double max_lead_s, bool open_loop = false)
      : max_lead_s_(max_lead_s), ahead_s_(open_loop ? 2.0 : 0.2), open_loop_(open_loop)
  {
  }

  void restart(double progress) { progress_ = progress, pace_ = 1.0; }

  /// Moves on by dt [s] with the vehicle at p_L on `curve`.
  void advance(double dt, const spline::UniformBSpline& curve, const spline::TimeLaw& law,
               const Eigen::Vector3d& p_L);

  [[nodiscard]] double progress() const { return progress_; }  ///< [s]
  [[nodiscard]] double pace() const { return pace_; }          ///< [1] in [0, 1]

 private:
  double max_lead_s_, ahead_s_;
  bool open_loop_;
  double progress_ = 0.0;
  double pace_ = 1.0;
};

}  // namespace slalom::engine
