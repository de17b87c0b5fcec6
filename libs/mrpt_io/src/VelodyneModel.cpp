// SPDX-License-Identifier: BSD-3-Clause
#include "VelodyneModel.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace slalom::mrpt_io::detail
{
namespace
{
using Calibration = mrpt::obs::VelodyneCalibration;

// User manuals of HDL-32E and HDL-64E S2/S3.
constexpr double kHdl32FiringPeriod = 46.08e-6, kHdl32LaserPeriod = 1.152e-6;
constexpr double kHdl64FiringPeriod = 48.0e-6;

Laser fromCalibration(const Calibration::PerLaserCalib& c)
{
  Laser laser;
  laser.sin_elevation = static_cast<float>(c.sinVertCorrection);
  laser.cos_elevation = static_cast<float>(c.cosVertCorrection);
  laser.distance_offset = static_cast<float>(c.distanceCorrection);
  laser.vertical_offset = static_cast<float>(c.verticalOffsetCorrection);
  laser.horizontal_offset = static_cast<float>(c.horizontalOffsetCorrection);
  laser.azimuth_offset = static_cast<int>(std::lround(100.0 * c.azimuthCorrection));
  return laser;
}

std::vector<Laser> lasersOf(const Calibration& calibration)
{
  std::vector<Laser> lasers;
  for (const auto& c : calibration.laser_corrections) lasers.push_back(fromCalibration(c));
  return lasers;
}

/// @param lasers_per_firing 16: the lasers of a VLP-16 fire twice per block
void setTiming(SensorModel& model, int lasers_per_firing, double firing_period, double laser_period)
{
  constexpr int kReturns = VelodynePacket::kReturnsPerBlock;
  model.block_period = kReturns / lasers_per_firing * firing_period;
  for (int i = 0; i < kReturns; ++i)
  {
    const int laser = i % lasers_per_firing;
    const double after = (i / lasers_per_firing) * firing_period + laser * laser_period;
    model.slots[static_cast<std::size_t>(i)] = {
        laser, static_cast<float>(after),
        static_cast<int>(std::lround(65536.0 * after / model.block_period))};
  }
}
}  // namespace

const SensorModel* SensorModels::vlp16()
{
  if (vlp16_.lasers.empty())
  {
    for (const int degrees : kVlp16Elevation)
    {
      const double elevation = degrees * std::numbers::pi / 180.0;
      Laser laser;
      laser.sin_elevation = static_cast<float>(std::sin(elevation));
      laser.cos_elevation = static_cast<float>(std::cos(elevation));
      vlp16_.lasers.push_back(laser);
    }
    setTiming(vlp16_, 16, VelodynePacket::kFiringPeriod, VelodynePacket::kLaserPeriod);
  }
  return &vlp16_;
}

const SensorModel* SensorModels::hdl32()
{
  if (hdl32_.lasers.empty())
  {
    const bool own = calibration_.laser_corrections.size() == 32;
    hdl32_.lasers = lasersOf(own ? calibration_ : Calibration::LoadDefaultCalibration("HDL32"));
    hdl32_.lasers.resize(32);
    setTiming(hdl32_, 32, kHdl32FiringPeriod, kHdl32LaserPeriod);
  }
  return &hdl32_;
}

const SensorModel* SensorModels::hdl64()
{
  // Every HDL-64 is calibrated on its own, and MRPT 2.5.8 fails to load its default for it.
  if (calibration_.laser_corrections.size() != 64) return nullptr;
  if (hdl64_.lasers.empty())
  {
    hdl64_.lasers = lasersOf(calibration_);
    setTiming(hdl64_, 32, kHdl64FiringPeriod, 0.0);
    hdl64_.two_banks = true;
  }
  return &hdl64_;
}

const SensorModel* SensorModels::of(const VelodynePacket& packet)
{
  if (isHdl64(packet)) return hdl64();
  if (packet.model == VelodynePacket::kVlp16) return vlp16();
  if (packet.model == VelodynePacket::kHdl32) return hdl32();
  return nullptr;
}

bool SensorModels::isHdl64(const VelodynePacket& packet)
{
  const auto lower = [](const VelodynePacket::Block& block) { return block.header == 0xDDFF; };
  return std::any_of(std::begin(packet.blocks), std::end(packet.blocks), lower);
}

}  // namespace slalom::mrpt_io::detail
