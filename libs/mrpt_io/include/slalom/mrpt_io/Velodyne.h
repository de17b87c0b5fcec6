// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/obs/CObservationVelodyneScan.h>

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "slalom/core/PointCloud.h"

namespace slalom::mrpt_io
{
#pragma pack(push, 1)
/// Layout of the 1206-byte data packet (Velodyne VLP-16 user manual, section 9): 12 blocks of 32
/// returns.
struct VelodynePacket
{
  static constexpr int kBlocks = 12, kReturnsPerBlock = 32;
  static constexpr double kFiringPeriod = 55.296e-6;  ///< [s] VLP-16: one firing of 16 lasers
  static constexpr double kLaserPeriod = 2.304e-6;  ///< [s] VLP-16: between two lasers of a firing
  static constexpr double kDistanceUnit = 0.002;    ///< [m]
  static constexpr std::uint8_t kVlp16 = 0x22, kHdl32 = 0x21;
  static constexpr std::uint8_t kStrongest = 0x37, kLast = 0x38, kDual = 0x39;

  struct Return
  {
    std::uint16_t distance;  ///< [2 mm]; 0 = no return
    std::uint8_t intensity;
  };
  struct Block
  {
    std::uint16_t header;   ///< 0xEEFF upper, 0xDDFF lower (HDL-64)
    std::uint16_t azimuth;  ///< [0.01 deg] clockwise seen from above
    Return returns[kReturnsPerBlock];
  };
  Block blocks[kBlocks];
  std::uint32_t microseconds;  ///< since the full hour (GPS)
  std::uint8_t return_mode;
  std::uint8_t model;
};
#pragma pack(pop)
static_assert(sizeof(VelodynePacket) == 1206);

/// VLP-16 elevation of each laser [deg], in firing order.
inline constexpr int kVlp16Elevation[16] = {-15, 1, -13, 3,  -11, 5,  -9, 7,
                                            -7,  9, -5,  11, -3,  13, -1, 15};

/** Decodes every return of a scan: all 32 of a block (MRPT 2.5.8 returns half of a VLP-16), single,
 * strongest/last and dual return, VLP-16 and HDL-32 / HDL-64 if the packet says so, with per-return
 * firing time and interpolated azimuth. Points are in sensor axes: x = r cos(el) cos(az), y = -r
 * cos(el) sin(az), z = r sin(el). Dual returns that repeat the first are dropped.
 *  @param dropped counters by reason: "zero range", "bad block header", "out of range", "unknown
 * model", "HDL-64 without calibration"; scan.minRange is ignored (MRPT's default of 1 m would hide
 * what is near), scan.maxRange is not */
void decodeVelodyne(const mrpt::obs::CObservationVelodyneScan& scan, core::RangeScan& out,
                    std::map<std::string, std::uint64_t>& dropped);

}  // namespace slalom::mrpt_io
