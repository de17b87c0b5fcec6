// SPDX-License-Identifier: BSD-3-Clause
// Range observations other than Velodyne packets.
#include <gtest/gtest.h>
#include <mrpt/maps/CSimplePointsMap.h>
#include <mrpt/obs/CObservation2DRangeScan.h>
#include <mrpt/obs/CObservation3DRangeScan.h>
#include <mrpt/obs/CObservationPointCloud.h>
#include <mrpt/obs/CObservationRotatingScan.h>

#include <cmath>
#include <limits>

#include "Packets.h"
#include "slalom/mrpt_io/ObservationDecoder.h"

using namespace slalom;
using mrpt_io::InputConfig;
using mrpt_io::ObservationDecoder;

namespace
{
template <class Observation>
Observation make()
{
  Observation o;
  o.timestamp = mrpt::Clock::fromDouble(1.7e9);
  o.sensorLabel = "S";
  return o;
}

core::RangeScan scanOf(ObservationDecoder& decoder, const mrpt::obs::CObservation& o)
{
  auto out = decoder.decode(o);
  EXPECT_EQ(out.size(), 1U);
  return out.empty() ? core::RangeScan() : std::get<core::RangeScan>(out[0]);
}

TEST(RangeDecoder, PointCloudsAreFilteredAndCounted)
{
  InputConfig config;
  config.min_range_m = 0.5;
  config.max_range_m = 20.0;
  auto o = make<mrpt::obs::CObservationPointCloud>();
  auto map = std::make_shared<mrpt::maps::CSimplePointsMap>();
  const float nan = std::numeric_limits<float>::quiet_NaN();
  map->insertPointFast(1, 2, 3);
  map->insertPointFast(nan, 0, 0);
  map->insertPointFast(0, std::numeric_limits<float>::infinity(), 0);
  map->insertPointFast(0, 0, 0);
  map->insertPointFast(0.1f, 0, 0);
  map->insertPointFast(0, 0, -30);
  o.pointcloud = map;
  o.sensorPose.setFromValues(0.1, 0.2, 0.3);
  ObservationDecoder decoder(config);
  const core::RangeScan scan = scanOf(decoder, o);
  ASSERT_EQ(scan.points.size(), 1U);
  EXPECT_EQ(scan.points[0].p_S, Eigen::Vector3f(1, 2, 3));
  EXPECT_EQ(scan.T_BS.translation(), Eigen::Vector3d(0.1, 0.2, 0.3));
  EXPECT_EQ(decoder.dropped().at("not finite"), 2U);
  EXPECT_EQ(decoder.dropped().at("zero range"), 1U);
  EXPECT_EQ(decoder.dropped().at("out of range"), 2U);
}

TEST(RangeDecoder, AnEmptyCloudIsAnEmptyScan)
{
  ObservationDecoder decoder{InputConfig()};
  EXPECT_TRUE(scanOf(decoder, make<mrpt::obs::CObservationPointCloud>()).points.empty());
}

TEST(RangeDecoder, ExternalFilesOutsideTheRecordingAreNotOpened)
{
  for (const char* file : {"/etc/passwd", "../../secret.txt"})
  {
    auto o = make<mrpt::obs::CObservationPointCloud>();
    o.setAsExternalStorage(file,
                           mrpt::obs::CObservationPointCloud::ExternalStorageFormat::PlainTextFile);
    ObservationDecoder decoder{InputConfig()};
    EXPECT_TRUE(scanOf(decoder, o).points.empty());
    EXPECT_EQ(decoder.dropped().at("external file outside the recording's folder"), 1U);
  }
}

// A plane seen by a depth camera must come back as that plane, in either meaning of "range".
TEST(RangeDecoder, DepthImagesOfAPlaneArePlanes)
{
  for (const bool is_depth : {true, false})
  {
    auto o = make<mrpt::obs::CObservation3DRangeScan>();
    o.cameraParams.setIntrinsicParamsFromValues(100, 110, 31.5, 23.5);
    o.hasRangeImage = true;
    o.range_is_depth = is_depth;
    o.rangeUnits = 1e-3f;
    o.rangeImage_setSize(48, 64);
    for (int row = 0; row < 48; ++row)
      for (int column = 0; column < 64; ++column)
      {
        const double ky = (31.5 - column) / 100, kz = (23.5 - row) / 110;
        const double range = is_depth ? 3.0 : 3.0 * std::sqrt(1 + ky * ky + kz * kz);
        o.rangeImage(row, column) = static_cast<std::uint16_t>(std::lround(1e3 * range));
      }
    o.rangeImage(5, 5) = 0;
    ObservationDecoder decoder{InputConfig()};
    const core::RangeScan scan = scanOf(decoder, o);
    ASSERT_EQ(scan.points.size(), 48U * 64 - 1);
    EXPECT_EQ(decoder.dropped().at("zero range"), 1U);
    for (const auto& p : scan.points) EXPECT_NEAR(p.p_S.x(), 3.0, 1e-3);
    // The first pixel is up and to the left.
    EXPECT_NEAR(scan.points[0].p_S.y(), 3.0 * 31.5 / 100, 2e-3);
    EXPECT_NEAR(scan.points[0].p_S.z(), 3.0 * 23.5 / 110, 2e-3);
  }
}

TEST(RangeDecoder, StoredPointsAreUsedWhenThereIsNoImage)
{
  auto o = make<mrpt::obs::CObservation3DRangeScan>();
  o.hasPoints3D = true;
  o.points3D_x = {1, 0};
  o.points3D_y = {2, 0};
  o.points3D_z = {3, 0};
  ObservationDecoder decoder{InputConfig()};
  const core::RangeScan scan = scanOf(decoder, o);
  ASSERT_EQ(scan.points.size(), 1U);
  EXPECT_EQ(scan.points[0].p_S, Eigen::Vector3f(1, 2, 3));
}

TEST(RangeDecoder, PlanarScansDropInvalidRays)
{
  auto o = make<mrpt::obs::CObservation2DRangeScan>();
  o.aperture = static_cast<float>(M_PI);
  o.maxRange = 10.0f;
  o.resizeScanAndAssign(181, 2.0f, true);
  o.setScanRangeValidity(0, false);
  o.setScanRange(1, 10.0f);
  ObservationDecoder decoder{InputConfig()};
  const core::RangeScan scan = scanOf(decoder, o);
  ASSERT_EQ(scan.points.size(), 179U);
  EXPECT_EQ(decoder.dropped().at("invalid 2-D range"), 2U);
  EXPECT_LT((scan.points[88].p_S - Eigen::Vector3f(2, 0, 0)).norm(), 1e-4) << "forward";
  EXPECT_LT((scan.points[178].p_S - Eigen::Vector3f(0, 2, 0)).norm(), 1e-4) << "left";
}

// The class keeps ranges in a ring-by-column image; MRPT fills it from Velodyne packets.
TEST(RangeDecoder, RotatingScansStandWhereTheirPacketsDo)
{
  core::Rng rng(3);
  test::Spin less_than_a_turn;
  less_than_a_turn.start_azimuth = 0.5;
  const auto velodyne = test::scanOf(test::spin(less_than_a_turn, 75, rng));
  auto o = make<mrpt::obs::CObservationRotatingScan>();
  o.fromVelodyne(*velodyne);
  o.timestamp = velodyne->timestamp;
  ObservationDecoder decoder{InputConfig()};
  const core::RangeScan image = scanOf(decoder, o);
  const core::RangeScan packets = scanOf(decoder, *velodyne);
  ASSERT_GT(image.points.size(), 10000U);
  // Every point of the image has a partner in the packets: same range, elevation and azimuth within
  // the image's column width.
  const auto key = [](const Eigen::Vector3f& p)
  {
    return std::pair(std::lround(p.norm() / 0.002),
                     std::lround(std::asin(p.z() / p.norm()) * 57.3));
  };
  std::multimap<std::pair<long, long>, Eigen::Vector3f> index;
  for (const auto& p : packets.points) index.emplace(key(p.p_S), p.p_S);
  int found = 0;
  for (const auto& p : image.points)
  {
    const auto [begin, end] = index.equal_range(key(p.p_S));
    for (auto it = begin; it != end; ++it)
      if ((it->second - p.p_S).norm() < 0.01f * p.p_S.norm())
      {
        ++found;
        break;
      }
  }
  EXPECT_GT(found, static_cast<int>(0.98 * static_cast<double>(image.points.size())));
}

TEST(RangeDecoder, RotatingScansOfUnknownShapeAreCounted)
{
  auto o = make<mrpt::obs::CObservationRotatingScan>();
  o.rowCount = 7;
  o.columnCount = 3;
  o.rangeImage.setSize(7, 3);
  ObservationDecoder decoder{InputConfig()};
  EXPECT_TRUE(scanOf(decoder, o).points.empty());
  EXPECT_EQ(decoder.dropped().at("rotating scan of an unknown sensor"), 1U);
}
}  // namespace
