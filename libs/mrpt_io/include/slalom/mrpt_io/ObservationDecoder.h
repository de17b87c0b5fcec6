// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/core/Clock.h>
#include <mrpt/obs/CObservation.h>

#include <Eigen/Core>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "slalom/core/Fields.h"
#include "slalom/core/Measurements.h"
#include "slalom/core/VehicleState.h"

namespace slalom::mrpt_io
{
/// INI section [input].
struct InputConfig
{
  std::string datum;        ///< "lat_deg,lon_deg,alt_m" origin of W; empty: the first GPS fix
  std::string gps_labels;   ///< comma-separated labels to use; empty: all
  std::string pose_labels;  ///< CObservationRobotPose labels used as pose source; empty: all except
                            ///< truth_label
  std::string truth_label =
      "GROUND_TRUTH";               ///< pose label that is truth: kept for metrics, never fused
  double gps_delay_s = 0.0;         ///< [s] subtracted from GPS stamps
  double min_range_m = 0.0;         ///< [m] nearer returns are dropped and counted
  double max_range_m = 120.0;       ///< [m] farther returns are dropped and counted
  double velocity_sigma_mps = 0.1;  ///< [m/s] of velocity observations that carry no covariance

  template <class Self, class Visit>
  static void fields(Self& c, Visit&& v)
  {
    using core::Level;
    using core::Range;
    v("datum", c.datum, "lat_deg,lon_deg,alt_m of the world origin; empty: the first GPS fix");
    v("gps_labels", c.gps_labels, "comma-separated GPS labels to use; empty: all");
    v("pose_labels", c.pose_labels, "pose observation labels to follow; empty: all but the truth");
    v("truth_label", c.truth_label, "label of ground-truth poses: for metrics only, never fused");
    v("gps_delay_s", c.gps_delay_s, Range{0.0, 2.0}, "age of a GPS fix at its time stamp",
      Level::Expert);
    v("min_range_m", c.min_range_m, Range{0.0, 10.0}, "nearer returns are dropped", Level::Expert);
    v("max_range_m", c.max_range_m, Range{1.0, 500.0}, "farther returns are dropped",
      Level::Expert);
    v("velocity_sigma_mps", c.velocity_sigma_mps, Range{1e-3, 10.0},
      "standard deviation of velocity observations", Level::Expert);
  }
};

/** MRPT observations to measurements in Slalom's words. Understands CObservationVelodyneScan,
 * CObservationPointCloud, CObservation3DRangeScan, CObservation2DRangeScan,
 * CObservationRotatingScan, CObservationGPS, CObservationIMU, CObservationOdometry,
 * CObservationRobotPose. Non-finite, zero and out-of-range points are dropped and counted; a scan
 * without points is still a measurement ("the sensor lives, nothing new").
 *
 * Conventions: IMU accelerations and rates give an ImuSample, turned by the mount into body axes
 * (its lever arm is not corrected); IMU_X_VEL, IMU_Y_VEL, IMU_Z_VEL are a velocity in world axes
 * (see Encoders.h); the twist of an odometry is a velocity in body axes without z, its pose counts
 * only when pose_labels names it. GGA gives positions (heights above sea level), RMC beside GGA the
 * horizontal velocity. A pose covariance of zero or identity means that nobody set it.
 *
 * Log time is seconds since the first observation with a valid time stamp that is understood. A
 * stamp more than a minute away from both its own sensor's and everybody's last one is counted and
 * not believed, unless the sensor repeats it three times and nobody contradicts (a pause). */
class ObservationDecoder
{
 public:
  explicit ObservationDecoder(const InputConfig& config);
  ~ObservationDecoder();

  /// Zero, one or several measurements (a GPS observation may give position and velocity).
  [[nodiscard]] std::vector<core::Measurement> decode(const mrpt::obs::CObservation& observation);

  /// Ground truth, if this observation is one.
  [[nodiscard]] std::optional<core::TimedPose> truth(const mrpt::obs::CObservation& observation);

  /// Log time of a stamp [s], not judged; fixes the epoch if nothing was decoded before.
  [[nodiscard]] double logTime(const mrpt::Clock::time_point& stamp);
  /// Unix time of log time 0 [s]; 0 before the first observation.
  [[nodiscard]] double epoch() const;
  /// Datum in use: latitude, longitude [deg], altitude [m].
  [[nodiscard]] std::optional<Eigen::Vector3d> datum() const;
  [[nodiscard]] const std::map<std::string, std::uint64_t>& dropped() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace slalom::mrpt_io
