// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/obs/VelodyneCalibration.h>

#include <array>
#include <cstdint>
#include <vector>

#include "slalom/mrpt_io/Velodyne.h"

namespace slalom::mrpt_io::detail
{
/// How one laser looks at the world.
struct Laser
{
  float sin_elevation = 0.0f, cos_elevation = 1.0f;
  float distance_offset = 0.0f;                            ///< [m]
  float vertical_offset = 0.0f, horizontal_offset = 0.0f;  ///< [m]
  int azimuth_offset = 0;                                  ///< [0.01 deg], subtracted
};

/// One of the 32 returns of a block: who fired it and when.
struct Slot
{
  int laser = 0;
  float after = 0.0f;  ///< [s] since the beginning of the block
  int turn_q16 = 0;    ///< share of the block's turn until then, times 2^16
};

/// What depends on the kind of sensor.
struct SensorModel
{
  std::vector<Laser> lasers;
  std::array<Slot, VelodynePacket::kReturnsPerBlock> slots;
  double block_period = 0.0;  ///< [s]
  bool two_banks = false;     ///< HDL-64: an upper and a lower block make one firing
};

/// Models of a scan's packets; those that are needed are built once.
class SensorModels
{
 public:
  /// @param calibration of the scan; used for HDL sensors when it has their number of lasers

  explicit SensorModels(const mrpt::obs::VelodyneCalibration& calibration)
      : calibration_(calibration)
  {
  }
  /// nullptr when the packet names a model that is not known here, or an HDL-64 has no calibration.
  [[nodiscard]] const SensorModel* of(const VelodynePacket& packet);
  /// HDL-64 packets have no model byte, but only they have a lower bank.
  [[nodiscard]] static bool isHdl64(const VelodynePacket& packet);

 private:
  const SensorModel* vlp16();
  const SensorModel* hdl32();
  const SensorModel* hdl64();

  const mrpt::obs::VelodyneCalibration& calibration_;
  SensorModel vlp16_, hdl32_, hdl64_;
};

}  // namespace slalom::mrpt_io::detail
