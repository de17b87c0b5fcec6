// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <vector>

#include "slalom/core/Fields.h"
#include "slalom/core/Rng.h"
#include "slalom/mrpt_io/Velodyne.h"
#include "slalom/simulation/Motion.h"
#include "slalom/simulation/World.h"

namespace slalom::simulation
{
/// INI section [lidar].
struct LidarConfig
{
  double rate_hz = 10.0;        ///< [1/s] revolutions
  int record_every = 1;         ///< [1] of so many revolutions one is recorded
  double min_range_m = 0.4;     ///< [m] blind nearer than this
  double max_range_m = 100.0;   ///< [m]
  double range_sigma_m = 0.02;  ///< [m] white
  double dropout = 0.005;       ///< [1] fraction of returns that get lost
  double fov_deg = 360.0;       ///< [deg] azimuths that see, around the sensor's x axis
  double outage_start_s = 0.0;  ///< [s] scans that begin from here on ...
  double outage_s = 0.0;        ///< [s] ... for so long are lost
  Eigen::Vector3d mount_m = Eigen::Vector3d(0.0, 0.0, 0.1);  ///< [m] in the body frame
  Eigen::Vector3d mount_rpy_deg = Eigen::Vector3d::Zero();   ///< roll, pitch, yaw

  template <class Self, class Visit>
  static void fields(Self& c, Visit&& v)
  {
    using core::Range;
    v("rate_hz", c.rate_hz, Range{5.0, 20.0}, "revolutions per second");
    v("record_every", c.record_every, Range{1, 100}, "of so many revolutions one is recorded");
    v("min_range_m", c.min_range_m, Range{0.0, 10.0}, "blind nearer than this");
    v("max_range_m", c.max_range_m, Range{1.0, 130.0}, "nothing is seen beyond");
    v("range_sigma_m", c.range_sigma_m, Range{0.0, 1.0}, "standard deviation of the range");
    v("dropout", c.dropout, Range{0.0, 1.0}, "fraction of returns that get lost");
    v("fov_deg", c.fov_deg, Range{1.0, 360.0},
      "horizontal field of view around the sensor's x axis; 360 = all around");
    v("outage_start_s", c.outage_start_s, Range{0.0, 1e6}, "scans from here on are lost ...");
    v("outage_s", c.outage_s, Range{0.0, 1e6}, "... for so long; 0 = none");
    v("mount_m", c.mount_m, "x,y,z of the sensor on the vehicle");
    v("mount_rpy_deg", c.mount_rpy_deg, "roll,pitch,yaw of the sensor on the vehicle");
  }
};

/** A Velodyne VLP-16 in strongest-return mode that turns without pause: 16 lasers fired one after
 * the other every 55.296 us while the head turns, each ray from where the vehicle is at that
 * moment. Of azimuths outside the field of view nothing is sent; in a packet that is half outside,
 * their blocks have no header. Outside the field of view nothing is sent: blocks of a packet half
 * outside lack their header. Packets are what the sensor sends, byte for byte; block azimuths are
 * true to 0.01 deg.
 *  @see VLP-16 user manual, section 9. Reflectivity is not modelled (constant). */
class Vlp16Model
{
 public:
  /// @param hour_offset [s] since the full hour at time 0, for the packets' clock
  Vlp16Model(const LidarConfig& config, std::uint64_t seed, double hour_offset = 0.0);

  /// The packets whose first firing falls into one revolution.
  struct Scan
  {
    double t = 0.0;    ///< [s] first firing that is told
    double end = 0.0;  ///< [s] when the last packet is complete
    std::vector<mrpt_io::VelodynePacket> packets;
  };
  [[nodiscard]] double nextScanStart() const;  ///< [s]
  [[nodiscard]] double nextScanEnd() const;    ///< [s]
  /// Fires the next revolution that is recorded. Deterministic: same seed, same calls, same bytes.
  [[nodiscard]] Scan nextScan(const World& world, const Motion& motion);

  [[nodiscard]] const Eigen::Isometry3d& mount() const { return T_BS_; }  ///< T_BS

 private:
  [[nodiscard]] mrpt_io::VelodynePacket packet(double t, const World& world, const Motion& motion);
  void fire(double t, const World& world, const Motion& motion,
            mrpt_io::VelodynePacket::Return* returns);
  [[nodiscard]] bool sees(double azimuth) const;
  [[nodiscard]] double azimuth(double t) const;  ///< [rad] clockwise, not wrapped
  [[nodiscard]] std::int64_t packetsUntil(std::int64_t revolution) const;

  LidarConfig config_;
  Eigen::Isometry3d T_BS_;
  core::Rng rng_;
  double hour_offset_;
  std::int64_t revolution_ = 0;
};

}  // namespace slalom::simulation
