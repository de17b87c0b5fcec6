// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <deque>

#include "slalom/simulation/Motion.h"

namespace slalom::simulation
{
/** The recent past of a motion that is not known in advance: states at equal steps of time,
 * interpolated between them, so that a sensor may look back as far as the memory goes. Position is
 * cubic between two states (Hermite), attitude turns at a constant rate, the rest is linear. Times
 * outside what is remembered are answered with the nearest state that is. Reading is thread-safe,
 * append() is not. */
class FlownPath : public Motion
{
 public:
  /** @param step [s] > 0 between two states
   *  @param memory [s] >= step, how far back it remembers at least
   *  @param start the state at time 0
   *  @throws std::invalid_argument */
  FlownPath(double step, double memory, const MotionSample& start);

  void append(const MotionSample& next);  ///< the state one step after the last one

  [[nodiscard]] double end() const;  ///< [s] time of the last state
  [[nodiscard]] const MotionSample& newest() const { return states_.back(); }

  [[nodiscard]] Eigen::Isometry3d pose(double t) const override;
  [[nodiscard]] MotionSample at(double t) const override;

 private:
  struct Interval
  {
    const MotionSample &from, &to;
    double share;  ///< [1] of the way from one to the other
  };
  [[nodiscard]] Interval around(double t) const;

  double step_;
  std::size_t remembered_;           // states
  std::int64_t forgotten_ = 0;       // states before the first that is remembered
  std::deque<MotionSample> states_;  // at least one
};

}  // namespace slalom::simulation
