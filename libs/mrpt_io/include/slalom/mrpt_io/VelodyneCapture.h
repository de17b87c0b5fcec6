// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/obs/CObservation.h>

#include <Eigen/Geometry>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <string>

namespace slalom::mrpt_io
{
struct CaptureOptions
{
  std::string scan_label = "VELODYNE", gps_label = "GPS";
  Eigen::Isometry3d T_BS = Eigen::Isometry3d::Identity();  ///< mount of the sensor on the vehicle
};

/// What a capture held so far.
struct CaptureStatistics
{
  std::uint64_t packets = 0;                     ///< data packets used
  std::uint64_t scans = 0;                       ///< observations made of them
  std::uint64_t position_packets = 0;            ///< with or without news
  std::uint64_t fixes = 0;                       ///< GPS observations made of them
  std::map<std::string, std::uint64_t> skipped;  ///< reason -> records
};

/** Streams a network capture of a Velodyne sensor as MRPT observations, with the capture's own
 * times: one CObservationVelodyneScan per turn (cut where the azimuth wraps; the first and the last
 * may be partial; a scan is stamped with the arrival of its first packet), and one CObservationGPS
 * for each new NMEA sentence (RMC, GGA) of the position packets. Classic pcap of either byte order
 * and resolution; Ethernet (with VLAN tags), Linux cooked or raw IPv4; data packets are UDP
 * payloads of 1206 bytes, position packets of 512. The first sensor address seen is followed.
 *  @throws RawlogError from constructor and next(): not a capture, or damaged (after everything
 * before the damage was delivered) */
class VelodyneCapture
{
 public:
  explicit VelodyneCapture(const std::filesystem::path& file, CaptureOptions options = {});
  ~VelodyneCapture();

  /// nullptr at the end.
  [[nodiscard]] mrpt::obs::CObservation::Ptr next();
  [[nodiscard]] const CaptureStatistics& statistics() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace slalom::mrpt_io
