// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "FilterState.h"
#include "slalom/core/Measurements.h"
#include "slalom/estimation/FilterConfig.h"

namespace slalom::estimation::detail
{
/// An IMU sample with the noise it deserves.
struct RatedImu
{
  core::ImuSample sample;
  double accel_density2 = 0.0;  ///< [m^2/s^4/Hz]
  double gyro_density2 = 0.0;   ///< [rad^2/s^2/Hz]
};

/** Rates the noise of a stream of IMU samples: the configured density, or the one seen in the first
 * differences of the signal when vibration makes it far larger. */
class ImuRater
{
 public:
  explicit ImuRater(const FilterConfig& config) : config_(config) {}
  [[nodiscard]] RatedImu rate(const core::ImuSample& sample);

 private:
  FilterConfig config_;
  bool primed_ = false;
  core::ImuSample last_;
  double accel_power_ = 0.0;  // fading mean of squared differences times dt
  double gyro_power_ = 0.0;
};

/** Mean square of the horizontal acceleration that noise and an uncertain tilt alone would show
 * [m^2/s^4]; a manoeuvre must exceed it to say anything about the heading. */
[[nodiscard]] double pretendedManoeuvre2(const FilterState& state, double accel_density2);

/** Strap-down step from state.t to `t` with the mean of two samples that enclose the interval.
 *  v += (R (f - ba) + g) dt, p by the trapezoidal rule, q by the exponential map; covariance with
 * the block-sparse transition matrix to second order in dt.
 *
 *  The horizontal force through which a heading error acts on velocity is shrunk by its
 * significance (James-Stein): else noise in hover counts as manoeuvres and the filter invents a
 * heading. */
void predictInertial(FilterState& state, double t, const RatedImu& before, const RatedImu& after,
                     const FilterConfig& config);

/** Step without IMU: constant velocity and heading with white manoeuvre and turn noise; the tilt
 * relaxes to level unless a pose source has told it lately. */
void predictKinematic(FilterState& state, double t, const FilterConfig& config);

}  // namespace slalom::estimation::detail
