// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/obs/CObservation.h>

#include <cstdint>
#include <functional>
#include <optional>
#include <string_view>
#include <vector>

#include "slalom/core/Fields.h"
#include "slalom/mrpt_io/Geodesy.h"
#include "slalom/simulation/NavigationSensors.h"
#include "slalom/simulation/Vlp16Model.h"
#include "slalom/simulation/World.h"

namespace slalom::simulation
{
/// INI section [record].
struct RecordConfig
{
  double epoch_s = 1767225600.0;  ///< [s] Unix time of the start: 2026-01-01 00:00 UTC
  double truth_rate_hz = 50.0;    ///< [1/s] ground truth poses
  int gzip_level = 6;             ///< [1] of the rawlog

  template <class Self, class Visit>
  static void fields(Self& c, Visit&& v)
  {
    using core::Range;
    v("epoch_s", c.epoch_s, Range{0.0, 4e9}, "Unix time of the start of the recording");
    v("truth_rate_hz", c.truth_rate_hz, Range{1.0, 500.0}, "ground truth poses per second");
    v("gzip_level", c.gzip_level, Range{0, 9}, "compression of the rawlog");
  }
};

/// All sensors on board.
struct SensorSuite
{
  RecordConfig record;
  LidarConfig lidar;
  ImuConfig imu;
  GpsConfig gps;
  VelocityConfig velocity;
};

/// Seed of a sensor's own random stream, so that one sensor's settings never change another's
/// noise.
[[nodiscard]] std::uint64_t streamSeed(std::uint64_t seed, std::string_view sensor);

/** Flies a motion through a world and gives what the sensors say, in order of time stamp (a lidar
 * scan is stamped with its first firing). Labels: VELODYNE, IMU, GPS, VELOCITY, GROUND_TRUTH.
 * Deterministic in (world, motion, suite, seed). World and motion must outlive it. */
class FlightRecorder
{
 public:
  FlightRecorder(const World& world, const Motion& motion, double duration,
                 const SensorSuite& suite, std::uint64_t seed);

  FlightRecorder(const FlightRecorder&) = delete;
  FlightRecorder& operator=(const FlightRecorder&) = delete;

  /// nullptr at the end of the flight; only whole scans are given.
  [[nodiscard]] mrpt::obs::CObservation::Ptr next();
  [[nodiscard]] double time() const { return time_; }  ///< [s] of the newest observation

  /** For a motion that is known up to the present only: what has arrived by `now` and was not told
   * before, in order of arrival. A scan arrives with its last packet. The same observations as from
   * next(), in another order. */
  [[nodiscard]] std::vector<mrpt::obs::CObservation::Ptr> arrivedBy(double now);

 private:
  struct Stream
  {
    double rate = 0.0;
    std::int64_t count = 0;
    std::function<mrpt::obs::CObservation::Ptr(double)> observe;  // nullptr in an outage
    [[nodiscard]] double next() const { return static_cast<double>(count) / rate; }
  };
  [[nodiscard]] mrpt::obs::CObservation::Ptr nextScan();
  [[nodiscard]] Stream& earliest();
  [[nodiscard]] mrpt::obs::CObservation::Ptr observe(Stream& stream);
  void addStreams(const SensorSuite& suite);

  const World& world_;
  const Motion& motion_;
  double duration_, epoch_, time_ = 0.0;
  mrpt_io::EnuFrame frame_;
  LidarConfig lidar_config_;
  Vlp16Model lidar_;
  ImuModel imu_;
  GpsModel gps_;
  VelocityModel velocity_;
  std::vector<Stream> streams_;
};

/// Where a sphere around the vehicle first comes nearer to a solid than its radius.
struct Contact
{
  double t = 0.0;  ///< [s]
  Eigen::Vector3d p_W = Eigen::Vector3d::Zero();
  double distance = 0.0;  ///< [m] centre to surface
};

/// First contact in [0, duration], sampled every 5 ms, with what stands or moves; the ground counts
/// for the centre alone.
[[nodiscard]] std::optional<Contact> firstContact(const World& world, const Motion& motion,
                                                  double duration, double radius);

}  // namespace slalom::simulation
