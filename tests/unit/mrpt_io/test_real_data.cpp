// SPDX-License-Identifier: BSD-3-Clause
// Recordings of real sensors. They are not part of the repository; absent files skip their test.
#include <gtest/gtest.h>
#include <mrpt/obs/CObservationVelodyneScan.h>

#include <cmath>
#include <set>

#include "SharedData.h"
#include "slalom/mrpt_io/ObservationDecoder.h"
#include "slalom/mrpt_io/RawlogReader.h"
#include "slalom/mrpt_io/Velodyne.h"

using namespace slalom;
namespace fs = std::filesystem;

namespace
{
#define NEED(file) \
  if (!fs::exists(file)) GTEST_SKIP() << file << " is absent"

std::vector<core::Measurement> measurements(const fs::path& file,
                                            mrpt_io::ObservationDecoder& decoder)
{
  std::vector<core::Measurement> all;
  mrpt_io::RawlogReader reader(file);
  while (const auto observation = reader.next())
    for (auto& m : decoder.decode(*observation)) all.push_back(std::move(m));
  return all;
}

/// Returns per full turn of the sensor, cut behind it, whatever the cuts between scans; partial
/// turns at both ends are left out.
std::vector<int> returnsPerRevolution(const fs::path& file)
{
  mrpt_io::ObservationDecoder decoder{mrpt_io::InputConfig()};
  std::vector<int> turns{0};
  float before = 0.0f;
  for (const auto& m : measurements(file, decoder))
    for (const auto& p : std::get<core::RangeScan>(m).points)
    {
      const float clockwise = std::atan2(-p.p_S.y(), p.p_S.x());
      if (before > clockwise + 3.0f) turns.push_back(0);
      before = clockwise;
      ++turns.back();
    }
  return turns.size() > 2 ? std::vector<int>(turns.begin() + 1, turns.end() - 1)
                          : std::vector<int>();
}

TEST(RealData, EveryReturnInThePacketsBecomesAPoint)
{
  for (const char* name :
       {"real/vlp16_einride_static/vlp16_13rev.rawlog", "real/vlp16_mrpt_pcap_gps/vlp16_gps.rawlog",
        "real/vlp16_mrpt_pcap_gps/test_velodyne_VLP16.rawlog"})
  {
    const fs::path file = test::sharedData(name);
    NEED(file);
    mrpt_io::RawlogReader reader(file);
    while (const auto observation = reader.next())
    {
      const auto scan = std::dynamic_pointer_cast<mrpt::obs::CObservationVelodyneScan>(observation);
      if (!scan) continue;
      std::size_t returns = 0;
      for (const auto& packet : scan->scan_packets)
        for (const auto& block : packet.blocks)
          for (const auto& r : block.laser_returns) returns += r.distance() > 0;
      core::RangeScan ours;
      std::map<std::string, std::uint64_t> dropped;
      mrpt_io::decodeVelodyne(*scan, ours, dropped);
      EXPECT_EQ(ours.points.size(), returns);
    }
  }
}

TEST(RealData, StaticVlp16HasAllReturnsOfARevolution)
{
  const fs::path file = test::sharedData("real/vlp16_einride_static/vlp16_13rev.rawlog");
  NEED(file);
  const std::vector<int> turns = returnsPerRevolution(file);
  ASSERT_GE(turns.size(), 11U);
  for (const int n : turns)
  {
    EXPECT_GE(n, 15250);
    EXPECT_LE(n, 15360);
  }
}

TEST(RealData, CapturedVlp16HasAllReturnsOfARevolution)
{
  const fs::path file = test::sharedData("real/vlp16_mrpt_pcap_gps/vlp16_gps.rawlog");
  NEED(file);
  const std::vector<int> turns = returnsPerRevolution(file);
  ASSERT_GE(turns.size(), 2U);
  for (const int n : turns)
  {
    EXPECT_GE(n, 18450);
    EXPECT_LE(n, 18600);
  }
}

TEST(RealData, MrptsPointsAreAmongOurs)
{
  const fs::path file = test::sharedData("real/vlp16_mrpt_pcap_gps/test_velodyne_VLP16.rawlog");
  NEED(file);
  mrpt_io::RawlogReader reader(file);
  const auto scan = std::dynamic_pointer_cast<mrpt::obs::CObservationVelodyneScan>(reader.next());
  ASSERT_TRUE(scan);
  core::RangeScan ours;
  std::map<std::string, std::uint64_t> dropped;
  mrpt_io::decodeVelodyne(*scan, ours, dropped);
  EXPECT_EQ(ours.points.size(), 22591U);
  mrpt::obs::CObservationVelodyneScan::TGeneratePointCloudParameters parameters;
  parameters.minDistance = 0.0f;
  scan->minRange = 0.0;
  scan->generatePointCloud(parameters);
  ASSERT_GT(scan->point_cloud.size(), 11000U);
  std::size_t at = 0;
  for (std::size_t i = 0; i < scan->point_cloud.size(); ++i)
  {
    const Eigen::Vector3f p(scan->point_cloud.x[i], scan->point_cloud.y[i], scan->point_cloud.z[i]);
    // MRPT turns by the packet's median rate, we by the rate to the next block.
    const float near = 6e-4f * p.norm() + 1e-3f;
    while (at < ours.points.size() && (ours.points[at].p_S - p).norm() > near) ++at;
    ASSERT_LT(at, ours.points.size()) << "point " << i << " is not among ours, in order";
  }
}

TEST(RealData, RotatingScanAndPacketsOfTheSameInstantAgree)
{
  const fs::path packets = "/usr/share/mrpt/datasets/test_velodyne_VLP16.rawlog";
  const fs::path image = "/usr/share/mrpt/datasets/rot_scan_velodyne.rawlog";
  NEED(packets);
  NEED(image);
  mrpt_io::ObservationDecoder decoder{mrpt_io::InputConfig()};
  const auto a = std::get<core::RangeScan>(measurements(packets, decoder).at(0));
  const auto b = std::get<core::RangeScan>(measurements(image, decoder).at(0));
  const auto voxel = [](const Eigen::Vector3f& p)
  {
    const Eigen::Vector3i v = (p / 0.25f).array().floor().cast<int>();
    return std::array<int, 3>{v.x(), v.y(), v.z()};
  };
  std::set<std::array<int, 3>> occupied;
  for (const auto& p : a.points) occupied.insert(voxel(p.p_S));
  int inside = 0;
  for (const auto& p : b.points) inside += static_cast<int>(occupied.count(voxel(p.p_S)));
  EXPECT_GT(inside, static_cast<int>(0.9 * static_cast<double>(b.points.size())));
}

TEST(RealData, RtkDriveHasThreeReceiversAndStartsWithThem)
{
  const fs::path file = test::sharedData("real/rtk_gps_mrpt/test_rtk_path.rawlog");
  NEED(file);
  mrpt_io::ObservationDecoder decoder{mrpt_io::InputConfig()};
  std::map<std::string, std::vector<core::PositionFix>> receivers;
  for (const auto& m : measurements(file, decoder))
    if (const auto* fix = std::get_if<core::PositionFix>(&m))
      receivers[fix->source].push_back(*fix);
  ASSERT_EQ(receivers.size(), 3U);
  EXPECT_EQ(receivers["GPS_RTK_FRONT_L"].size(), 307U);
  EXPECT_EQ(receivers["GPS_RTK_FRONT_R"].size(), 307U);
  EXPECT_EQ(receivers["GPS_RTK_REAR"].size(), 77U);
  // The comment at the head of the file is dated 2011, the drive 2008-11-09.
  EXPECT_NEAR(decoder.epoch(), 1226225355.0, 1.0);
  for (const auto& [label, fixes] : receivers)
  {
    EXPECT_NEAR(fixes.back().t, 76.2, 1.0) << label;
    EXPECT_LT(fixes.front().sigma.x(), 0.5) << label << " is RTK";
  }
  // Front antennas of one car keep their distance, but for the stretch where one loses its fix.
  const auto& left = receivers["GPS_RTK_FRONT_L"];
  const auto& right = receivers["GPS_RTK_FRONT_R"];
  const double apart = (left[0].p_W - right[0].p_W).norm();
  EXPECT_NEAR(apart, 1.59, 0.05);
  int same = 0, pairs = 0;
  for (std::size_t i = 0; i < left.size(); ++i)
  {
    if (std::abs(left[i].t - right[i].t) > 0.01) continue;
    ++pairs;
    same += std::abs((left[i].p_W - right[i].p_W).norm() - apart) < 0.1;
  }
  EXPECT_GT(pairs, 250);
  EXPECT_GT(same, pairs * 9 / 10);
}

TEST(RealData, FlightsGiveImuGpsAndVelocity)
{
  const fs::path file = test::sharedData("real/px4_outdoor_manual_fast/flight.rawlog");
  NEED(file);
  mrpt_io::ObservationDecoder decoder{mrpt_io::InputConfig()};
  std::map<std::size_t, int> kinds;
  Eigen::Vector3d rest = Eigen::Vector3d::Zero();
  int resting = 0;
  for (const auto& m : measurements(file, decoder))
  {
    ++kinds[m.index()];
    if (const auto* imu = std::get_if<core::ImuSample>(&m); imu && imu->t < 5.0)
    {
      rest += imu->f_B;
      ++resting;
    }
  }
  EXPECT_EQ(kinds[0], 15843);
  EXPECT_EQ(kinds[1], 397);
  EXPECT_EQ(kinds[2], 397);
  EXPECT_NEAR((rest / resting).z(), 9.8, 0.3) << "forward-left-up: gravity is felt upwards";
}

TEST(RealData, IndoorFlightHasNoFixAndNoDatum)
{
  const fs::path file = test::sharedData("real/px4_indoor_offboard/flight.rawlog");
  NEED(file);
  mrpt_io::ObservationDecoder decoder{mrpt_io::InputConfig()};
  for (const auto& m : measurements(file, decoder))
    EXPECT_FALSE(std::holds_alternative<core::PositionFix>(m));
  EXPECT_FALSE(decoder.datum().has_value());
}

TEST(RealData, EveryDatasetOfMrptOpens)
{
  const fs::path folder = "/usr/share/mrpt/datasets";
  NEED(folder);
  int opened = 0;
  for (const auto& entry : fs::directory_iterator(folder))
  {
    if (entry.path().extension() != ".rawlog") continue;
    SCOPED_TRACE(entry.path());
    mrpt_io::ObservationDecoder decoder{mrpt_io::InputConfig()};
    mrpt_io::RawlogReader reader(entry.path());
    std::uint64_t seen = 0;
    while (const auto observation = reader.next())
    {
      ++seen;
      for (const auto& m : decoder.decode(*observation))
        EXPECT_TRUE(std::isfinite(core::timeOf(m)));
    }
    EXPECT_GT(seen, 0U);
    ++opened;
  }
  EXPECT_GT(opened, 5);
}
}  // namespace
