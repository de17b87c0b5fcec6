// SPDX-License-Identifier: BSD-3-Clause
#include "slalom/simulation/Vlp16Model.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <numbers>

#include "slalom/core/Math.h"

namespace slalom::simulation
{
namespace
{
using mrpt_io::VelodynePacket;

constexpr int kLasers = 16;
constexpr int kFiringsPerPacket = 24;
constexpr double kPacketPeriod = kFiringsPerPacket * VelodynePacket::kFiringPeriod;
constexpr double kTurn = 2.0 * std::numbers::pi;
constexpr double kRadian = std::numbers::pi / 180.0;
constexpr std::uint8_t kReflectivity = 40;

struct Elevation
{
  double sine, cosine;
};

const std::array<Elevation, kLasers>& elevations()
{
  static const std::array<Elevation, kLasers> table = []
  {
    std::array<Elevation, kLasers> t;
    for (std::size_t l = 0; l < kLasers; ++l)
      t[l] = {std::sin(mrpt_io::kVlp16Elevation[l] * kRadian),
              std::cos(mrpt_io::kVlp16Elevation[l] * kRadian)};
    return t;
  }();
  return table;
}

Eigen::Isometry3d mountOf(const LidarConfig& config)
{
  const Eigen::Vector3d rpy = config.mount_rpy_deg * kRadian;
  Eigen::Isometry3d mount(core::fromYaw(rpy.z()) *
                          Eigen::AngleAxisd(rpy.y(), Eigen::Vector3d::UnitY()) *
                          Eigen::AngleAxisd(rpy.x(), Eigen::Vector3d::UnitX()));
  mount.translation() = config.mount_m;
  return mount;
}

std::uint16_t centidegrees(double angle)
{
  const double turns = angle / kTurn;
  const int rounded = static_cast<int>(std::lround((turns - std::floor(turns)) * 36000.0));
  return static_cast<std::uint16_t>(rounded % 36000);
}
}  // namespace

Vlp16Model::Vlp16Model(const LidarConfig& config, std::uint64_t seed, double hour_offset)
    : config_(config), T_BS_(mountOf(config)), rng_(seed), hour_offset_(hour_offset)
{
}

double Vlp16Model::azimuth(double t) const
{
  return kTurn * config_.rate_hz * t;
}

/// Packets that start before the given revolution does.
std::int64_t Vlp16Model::packetsUntil(std::int64_t revolution) const
{
  const double start = static_cast<double>(revolution) / config_.rate_hz;
  return static_cast<std::int64_t>(std::ceil(start / kPacketPeriod - 1e-9));
}

double Vlp16Model::nextScanStart() const
{
  return kPacketPeriod * static_cast<double>(packetsUntil(revolution_));
}

double Vlp16Model::nextScanEnd() const
{
  return kPacketPeriod * static_cast<double>(packetsUntil(revolution_ + 1));
}

Vlp16Model::Scan Vlp16Model::nextScan(const World& world, const Motion& motion)
{
  Scan scan;
  scan.t = nextScanStart();
  scan.end = nextScanEnd();
  const std::int64_t first = packetsUntil(revolution_), last = packetsUntil(revolution_ + 1);
  scan.packets.reserve(static_cast<std::size_t>(last - first));
  for (std::int64_t k = first; k < last; ++k)
  {
    const VelodynePacket next = packet(kPacketPeriod * static_cast<double>(k), world, motion);
    const auto told = [](const VelodynePacket::Block& block) { return block.header != 0; };
    if (std::none_of(std::begin(next.blocks), std::end(next.blocks), told)) continue;
    if (scan.packets.empty()) scan.t = kPacketPeriod * static_cast<double>(k);
    scan.packets.push_back(next);
  }
  revolution_ += config_.record_every;
  return scan;
}

VelodynePacket Vlp16Model::packet(double t, const World& world, const Motion& motion)
{
  VelodynePacket packet{};
  for (int b = 0; b < VelodynePacket::kBlocks; ++b)
  {
    VelodynePacket::Block& block = packet.blocks[b];
    const double start = t + 2 * b * VelodynePacket::kFiringPeriod;
    block.azimuth = centidegrees(azimuth(start));
    // What is outside the field of view is not told, which is not the same as no echo.
    if (!sees(azimuth(start)) && !sees(azimuth(start + 2 * VelodynePacket::kFiringPeriod)))
      continue;
    block.header = 0xEEFF;
    fire(start, world, motion, block.returns);
    fire(start + VelodynePacket::kFiringPeriod, world, motion, block.returns + kLasers);
  }
  const double in_hour = std::fmod(hour_offset_ + t, 3600.0);
  packet.microseconds = static_cast<std::uint32_t>(std::llround(in_hour * 1e6) % 3'600'000'000);
  packet.return_mode = VelodynePacket::kStrongest;
  packet.model = VelodynePacket::kVlp16;
  return packet;
}

bool Vlp16Model::sees(double azimuth) const
{
  return config_.fov_deg >= 360.0 ||
         std::abs(core::wrapAngle(azimuth)) <= 0.5 * config_.fov_deg * kRadian;
}

void Vlp16Model::fire(double t, const World& world, const Motion& motion,
                      VelodynePacket::Return* returns)
{
  // Within the 35 us of a firing the vehicle, or a mover, moves by some 0.04 mm: one pose each.
  const Eigen::Isometry3d T_WS =
      motion.pose(t + 0.5 * (kLasers - 1) * VelodynePacket::kLaserPeriod) * T_BS_;
  const MoversAt movers(world.movers(), t);
  for (int l = 0; l < kLasers; ++l)
  {
    const double turned = azimuth(t + l * VelodynePacket::kLaserPeriod);
    if (!sees(turned)) continue;
    const Elevation& e = elevations()[static_cast<std::size_t>(l)];
    const Eigen::Vector3d direction_S(e.cosine * std::cos(turned), -e.cosine * std::sin(turned),
                                      e.sine);
    const Eigen::Vector3d direction_W = T_WS.linear() * direction_S;
    std::optional<double> hit = world.castRay(T_WS.translation(), direction_W, config_.max_range_m);
    if (const auto moving =
            movers.castRay(T_WS.translation(), direction_W, hit.value_or(config_.max_range_m)))
      hit = moving;
    if (!hit || *hit < config_.min_range_m || rng_.uniform() < config_.dropout) continue;
    const double range = *hit + config_.range_sigma_m * rng_.normal();
    const double units = std::round(range / VelodynePacket::kDistanceUnit);
    if (units < 1.0 || units > 65535.0) continue;
    returns[l].distance = static_cast<std::uint16_t>(units);
    returns[l].intensity = kReflectivity;
  }
}

}  // namespace slalom::simulation
