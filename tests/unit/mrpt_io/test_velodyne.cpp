// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>

#include "Packets.h"
#include "slalom/mrpt_io/Velodyne.h"

using namespace slalom;
using mrpt_io::VelodynePacket;
using test::scanOf;
using test::Spin;
using test::spin;

namespace
{
constexpr double kDegree = std::numbers::pi / 180.0;

struct Decoded
{
  core::RangeScan scan;
  std::map<std::string, std::uint64_t> dropped;
};

Decoded decode(const std::vector<VelodynePacket>& packets)
{
  Decoded d;
  mrpt_io::decodeVelodyne(*scanOf(packets), d.scan, d.dropped);
  return d;
}

/// Where and when the manual says a return was fired.
struct Expected
{
  double range, elevation, azimuth, time;  ///< [m], [deg], [deg], [s]
};

/// The user manual's own words, in double precision and without tables.
std::vector<Expected> manual(const Spin& s, const std::vector<VelodynePacket>& packets)
{
  const bool vlp16 = s.model == VelodynePacket::kVlp16;
  const int lasers = vlp16 ? 16 : 32, group = s.mode == VelodynePacket::kDual ? 2 : 1;
  const double firing = vlp16 ? 55.296e-6 : 46.08e-6, laser_time = vlp16 ? 2.304e-6 : 1.152e-6;
  std::vector<double> elevations;
  for (const auto& laser :
       mrpt::obs::VelodyneCalibration::LoadDefaultCalibration("HDL32").laser_corrections)
    elevations.push_back(laser.verticalCorrection);
  std::vector<Expected> all;
  for (std::size_t k = 0; k < packets.size(); ++k)
    for (int b = 0; b < 12; ++b)
      for (int i = 0; i < 32; ++i)
      {
        const auto& block = packets[k].blocks[b];
        const int units = block.returns[i].distance, laser = i % lasers;
        const bool repeats =
            group == 2 && b % 2 == 1 && units == packets[k].blocks[b - 1].returns[i].distance;
        if (units == 0 || repeats) continue;
        const double after = (i / lasers) * firing + laser * laser_time;
        const std::int64_t elapsed_us =
            (packets[k].microseconds + 3600000000LL - packets[0].microseconds) % 3600000000LL;
        const double packet_start = 1e-6 * static_cast<double>(elapsed_us);
        all.push_back({0.002 * units,
                       vlp16 ? (laser % 2 == 0 ? -15.0 + laser : laser)
                             : elevations[static_cast<std::size_t>(laser)],
                       block.azimuth / 100.0 + s.turn_rate * after,
                       packet_start + (b / group) * s.block_period + after});
      }
  return all;
}

void expectManual(const Spin& s, const std::vector<VelodynePacket>& packets)
{
  const Decoded d = decode(packets);
  const std::vector<Expected> expected = manual(s, packets);
  ASSERT_EQ(d.scan.points.size(), expected.size());
  double worst = 0.0, worst_time = 0.0, last = 0.0;
  for (std::size_t i = 0; i < expected.size(); ++i)
  {
    const Expected& e = expected[i];
    const double el = e.elevation * kDegree, az = e.azimuth * kDegree;
    const Eigen::Vector3d p(e.range * std::cos(el) * std::cos(az),
                            -e.range * std::cos(el) * std::sin(az), e.range * std::sin(el));
    const core::ScanPoint& q = d.scan.points[i];
    worst = std::max(worst, (q.p_S.cast<double>() - p).norm() / e.range);
    worst_time = std::max(worst_time, std::abs(static_cast<double>(q.dt) - e.time));
    last = std::max(last, e.time);
  }
  // Two azimuths of 0.01 deg steps make the rate, and the result is rounded to such a step again.
  EXPECT_LT(worst, 0.015 * kDegree);
  EXPECT_LT(worst_time, 1e-7);
  EXPECT_NEAR(d.scan.duration, last, 1e-7);
}

TEST(Velodyne, EveryReturnStandsWhereTheManualSays)
{
  for (std::uint64_t seed = 1; seed <= 12; ++seed)
  {
    SCOPED_TRACE(seed);
    core::Rng rng(seed);
    Spin s;
    s.turn_rate = rng.uniform(1800.0, 7200.0);
    s.start_azimuth = rng.uniform(0.0, 360.0);
    if (seed % 3 == 1) s.mode = VelodynePacket::kDual;
    if (seed % 2 == 1)
    {
      s.model = VelodynePacket::kHdl32;
      s.block_period = 46.08e-6;
    }
    if (seed % 4 == 0) s.start_us = 3599999000;  // the hour turns within the scan
    expectManual(s, spin(s, 20, rng));
  }
}

TEST(Velodyne, CountsWhatItDrops)
{
  core::Rng rng(5);
  auto packets = spin(Spin(), 10, rng);
  std::uint64_t zero = 0;
  for (const auto& packet : packets)
    for (const auto& block : packet.blocks)
      for (const auto& r : block.returns) zero += r.distance == 0;
  const Decoded whole = decode(packets);
  EXPECT_EQ(whole.dropped.at("zero range"), zero);
  EXPECT_EQ(whole.scan.points.size() + zero, 10U * 12 * 32);
  EXPECT_EQ(whole.dropped.size(), 1U);

  packets[2].blocks[3].header = 0x1234;
  packets[4].blocks[5].azimuth = 36000;
  packets[7].model = 0x77;
  const Decoded broken = decode(packets);
  EXPECT_EQ(broken.dropped.at("bad block header"), 64U);
  EXPECT_EQ(broken.dropped.at("unknown model"), 384U);
  std::uint64_t all = broken.scan.points.size();
  for (const auto& [reason, count] : broken.dropped) all += count;
  EXPECT_EQ(all, 10U * 12 * 32);
}

TEST(Velodyne, OnlyLastingSilenceIsToldAndWhereItsEchoesWouldHaveBeen)
{
  core::Rng rng(6);
  // Laser 3 hears nothing from firing 20 to 60, laser 7 misses single echoes only.
  auto packets = spin(Spin(), 10, rng), heard = packets;
  const auto answer = [](std::vector<VelodynePacket>& all, bool silent)
  {
    int firing = 0;
    for (auto& packet : all)
      for (auto& block : packet.blocks)
        for (int half = 0; half < 2; ++half, ++firing)
          for (int laser = 0; laser < 16; ++laser)
          {
            const bool quiet =
                (laser == 3 && firing >= 20 && firing <= 60) || (laser == 7 && firing % 3 == 0);
            const bool mute = !silent && !(laser == 3 && firing >= 22 && firing <= 58);
            block.returns[16 * half + laser].distance =
                static_cast<std::uint16_t>((silent && quiet) || mute ? 0 : 5000);
          }
  };
  answer(packets, true);
  answer(heard, false);  // nothing but what the others should call silent
  const Decoded quiet = decode(packets), loud = decode(heard);
  ASSERT_EQ(quiet.scan.silent.size(), 37U);
  ASSERT_EQ(loud.scan.points.size(), 37U);
  for (std::size_t i = 0; i < 37; ++i)
  {
    EXPECT_LT((quiet.scan.silent[i].p_S - loud.scan.points[i].p_S.normalized()).norm(), 1e-5f);
    EXPECT_EQ(quiet.scan.silent[i].dt, loud.scan.points[i].dt);
  }
}

TEST(Velodyne, AnEmptyScanIsEmpty)
{
  const Decoded d = decode({});
  EXPECT_TRUE(d.scan.points.empty());
  EXPECT_EQ(d.scan.duration, 0.0);
}

TEST(Velodyne, AStoppedClockIsReplacedByTheNominalRate)
{
  core::Rng rng(6);
  auto packets = spin(Spin(), 10, rng);
  const Decoded good = decode(packets);
  for (auto& packet : packets) packet.microseconds = 42;
  const Decoded stopped = decode(packets);
  ASSERT_EQ(good.scan.points.size(), stopped.scan.points.size());
  for (std::size_t i = 0; i < good.scan.points.size(); ++i)
    EXPECT_NEAR(good.scan.points[i].dt, stopped.scan.points[i].dt, 2e-6);
  packets[5].microseconds = 3000000000;
  EXPECT_NEAR(decode(packets).scan.duration, good.scan.duration, 2e-6);
}

TEST(Velodyne, Hdl64TakesBothBanksAndTheirCorrections)
{
  core::Rng rng(7);
  Spin s;
  s.mode = 'V';  // where other models tell the return mode, this one sends status bytes
  s.model = 10;
  auto packets = spin(s, 4, rng);
  for (auto& packet : packets)
    for (int b = 1; b < 12; b += 2)
    {
      packet.blocks[b].header = 0xDDFF;
      packet.blocks[b].azimuth = packet.blocks[b - 1].azimuth;
    }
  const auto scan = scanOf(packets);
  Decoded d;
  mrpt_io::decodeVelodyne(*scan, d.scan, d.dropped);
  EXPECT_TRUE(d.scan.points.empty());
  EXPECT_EQ(d.dropped.at("HDL-64 without calibration"), 4U * 384);

  auto& lasers = scan->calibration.laser_corrections;
  lasers.resize(64);
  for (auto& laser : lasers)
  {
    laser.verticalCorrection = rng.uniform(-25.0, 2.0);
    laser.sinVertCorrection = std::sin(laser.verticalCorrection * kDegree);
    laser.cosVertCorrection = std::cos(laser.verticalCorrection * kDegree);
    laser.distanceCorrection = rng.uniform(-0.1, 1.5);
    laser.verticalOffsetCorrection = rng.uniform(-0.2, 0.2);
  }
  d = Decoded();
  mrpt_io::decodeVelodyne(*scan, d.scan, d.dropped);
  std::size_t n = 0;
  for (const auto& packet : packets)
    for (int b = 0; b < 12; ++b)
      for (int i = 0; i < 32; ++i)
      {
        const auto& laser = lasers[static_cast<std::size_t>(i + (b % 2) * 32)];
        const double r = 0.002 * packet.blocks[b].returns[i].distance;
        if (r == 0.0) continue;
        const double el = laser.verticalCorrection * kDegree;
        const double z = (r + laser.distanceCorrection) * std::sin(el) +
                         laser.verticalOffsetCorrection * std::cos(el);
        ASSERT_LT(n, d.scan.points.size());
        EXPECT_NEAR(d.scan.points[n++].p_S.z(), z, 1e-3);
      }
  EXPECT_EQ(n, d.scan.points.size());
}

TEST(Velodyne, NoiseNeverGivesAPointThatIsNotFinite)
{
  for (std::uint64_t seed = 1; seed <= 200; ++seed)
  {
    SCOPED_TRACE(seed);
    core::Rng rng(seed);
    std::vector<VelodynePacket> packets(4);
    for (auto& packet : packets)
    {
      auto* bytes = reinterpret_cast<unsigned char*>(&packet);
      for (std::size_t i = 0; i < sizeof(packet); ++i)
        bytes[i] = static_cast<unsigned char>(rng.integer(0, 255));
      for (auto& block : packet.blocks)
        if (rng.uniform() < 0.8) block.header = rng.uniform() < 0.9 ? 0xEEFF : 0xDDFF;
      if (rng.uniform() < 0.8) packet.model = rng.uniform() < 0.5 ? 0x22 : 0x21;
      if (rng.uniform() < 0.3) packet.return_mode = VelodynePacket::kDual;
    }
    const Decoded d = decode(packets);
    for (const auto& point : d.scan.points)
    {
      ASSERT_TRUE(point.p_S.allFinite());
      ASSERT_GE(point.dt, 0.0f);
      ASSERT_LE(point.dt, d.scan.duration * (1.0 + 1e-6));
    }
  }
}

// MRPT 2.5.8 decodes the first 16 returns of each block; those must be among ours.
TEST(Velodyne, ContainsMrptsPoints)
{
  core::Rng rng(8);
  const auto scan = scanOf(spin(Spin(), 30, rng));
  core::RangeScan ours;
  std::map<std::string, std::uint64_t> dropped;
  mrpt_io::decodeVelodyne(*scan, ours, dropped);
  mrpt::obs::CObservationVelodyneScan::TGeneratePointCloudParameters parameters;
  parameters.minDistance = 0.0f;
  scan->minRange = 0.0;
  scan->generatePointCloud(parameters);
  const auto& theirs = scan->point_cloud;
  ASSERT_GT(theirs.size(), 4000U);
  EXPECT_GT(ours.points.size(), theirs.size() * 19 / 10);
  std::size_t at = 0;
  for (std::size_t i = 0; i < theirs.size(); ++i)
  {
    const Eigen::Vector3f p(theirs.x[i], theirs.y[i], theirs.z[i]);
    const float near = 4e-4f * p.norm() + 1e-3f;  // 0.02 deg: MRPT turns by the median rate
    while (at < ours.points.size() && (ours.points[at].p_S - p).norm() > near) ++at;
    ASSERT_LT(at, ours.points.size()) << "point " << i << " is not among ours, in order";
  }
}
}  // namespace
