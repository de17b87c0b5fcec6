// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/obs/CObservationVelodyneScan.h>

#include <cmath>
#include <cstring>
#include <vector>

#include "slalom/core/Rng.h"
#include "slalom/mrpt_io/Encoders.h"

namespace slalom::test
{
/// How a synthetic sensor spins and answers.
struct Spin
{
  std::uint8_t model = mrpt_io::VelodynePacket::kVlp16;
  std::uint8_t mode = mrpt_io::VelodynePacket::kStrongest;
  double block_period = 110.592e-6;  ///< [s]
  double turn_rate = 3600.0;         ///< [deg/s]
  double start_azimuth = 123.4;      ///< [deg]
  std::uint32_t start_us = 1000;
};

/// Packets with true azimuths and clocks and random distances (a fifth of them zero). In dual mode
/// a third of the second returns repeat the first.
[[nodiscard]] inline std::vector<mrpt_io::VelodynePacket> spin(const Spin& s, int count,
                                                               core::Rng& rng)
{
  using mrpt_io::VelodynePacket;
  const int group = s.mode == VelodynePacket::kDual ? 2 : 1;
  std::vector<VelodynePacket> packets(static_cast<std::size_t>(count));
  const auto distance = [&]
  { return static_cast<std::uint16_t>(rng.uniform() < 0.2 ? 0 : rng.integer(100, 60000)); };
  for (int k = 0; k < count; ++k)
  {
    VelodynePacket& packet = packets[static_cast<std::size_t>(k)];
    packet = VelodynePacket();
    packet.model = s.model;
    packet.return_mode = s.mode;
    const double start = k * (VelodynePacket::kBlocks / group) * s.block_period;
    packet.microseconds =
        static_cast<std::uint32_t>((s.start_us + std::llround(1e6 * start)) % 3600000000LL);
    for (int b = 0; b < VelodynePacket::kBlocks; ++b)
    {
      auto& block = packet.blocks[b];
      const double azimuth = s.start_azimuth + s.turn_rate * (start + (b / group) * s.block_period);
      block.header = 0xEEFF;
      block.azimuth = static_cast<std::uint16_t>(std::llround(100.0 * azimuth) % 36000);
      for (int i = 0; i < VelodynePacket::kReturnsPerBlock; ++i)
      {
        const bool repeat = group == 2 && b % 2 == 1 && rng.uniform() < 0.33;
        block.returns[i].distance = repeat ? packet.blocks[b - 1].returns[i].distance : distance();
      }
    }
  }
  return packets;
}

[[nodiscard]] inline std::shared_ptr<mrpt::obs::CObservationVelodyneScan> scanOf(
    const std::vector<mrpt_io::VelodynePacket>& packets)
{
  return std::dynamic_pointer_cast<mrpt::obs::CObservationVelodyneScan>(
      mrpt_io::makeVelodyneObservation(1.7e9, packets, Eigen::Isometry3d::Identity()));
}

}  // namespace slalom::test
