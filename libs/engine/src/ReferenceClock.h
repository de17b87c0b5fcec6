// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "slalom/core/Vehicle.h"
#include "slalom/spline/UniformBSpline.h"

namespace slalom::engine
{
/** Runs the parameter of the reference. It advances with time, but never farther than `max_lead`
 * ahead of the vehicle's own projection and never backwards, so a delayed vehicle does not meet a
 * runaway reference; and it advances slower than time where the refined curve asks for more speed
 * than the vehicle has. @see deviation D-10 (docs/paper_map.md) */
class ReferenceClock
{
 public:
  explicit ReferenceClock(double max_lead_s) : max_lead_s_(max_lead_s) {}

  void restart(double progress) { progress_ = progress, rate_ = 1.0; }

  /// Moves on by dt [s] with the vehicle at p_L on `curve`, not beyond `stop_at`.
  void advance(double dt, const spline::UniformBSpline& curve, const Eigen::Vector3d& p_L,
               double stop_at, const core::Vehicle& vehicle);

  [[nodiscard]] double progress() const { return progress_; }  ///< [s]
  [[nodiscard]] double rate() const { return rate_; }          ///< [1] in (0, 1]

 private:
  double max_lead_s_;
  double progress_ = 0.0;
  double rate_ = 1.0;
};

}  // namespace slalom::engine
