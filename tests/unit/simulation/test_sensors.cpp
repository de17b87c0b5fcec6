// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <mrpt/obs/CObservationIMU.h>
#include <mrpt/obs/CObservationVelodyneScan.h>

#include <cmath>
#include <cstring>
#include <map>

#include "Observations.h"
#include "TempFile.h"
#include "slalom/core/Rng.h"
#include "slalom/mrpt_io/Encoders.h"
#include "slalom/mrpt_io/ObservationDecoder.h"
#include "slalom/mrpt_io/RawlogReader.h"
#include "slalom/mrpt_io/RawlogWriter.h"
#include "slalom/simulation/FlightRecorder.h"
#include "slalom/simulation/Forest.h"
#include "slalom/simulation/ScriptedFlight.h"

namespace slalom::simulation
{
namespace
{
using Eigen::Vector3d;
using mrpt::obs::CObservationVelodyneScan;
using mrpt_io::VelodynePacket;
using test::bytesOf;

/// Stands still, or turns and drifts at constant rates.
struct SteadyMotion : Motion
{
  Vector3d p{0.0, 0.0, 1.5}, v{0.0, 0.0, 0.0};
  double yaw_rate = 0.0;

  MotionSample at(double t) const override
  {
    MotionSample m;
    m.p_W = p + t * v;
    m.v_W = v;
    m.q_WB = hoverAttitude(Vector3d::Zero(), 0.3 + yaw_rate * t);
    m.w_B = {0.0, 0.0, yaw_rate};
    return m;
  }
  Eigen::Isometry3d pose(double t) const override
  {
    const MotionSample m = at(t);
    Eigen::Isometry3d T(m.q_WB);
    T.translation() = m.p_W;
    return T;
  }
};

World smallForest()
{
  return World::of(makeForest({}, 3), {}, true);
}

LidarConfig exactLidar()
{
  LidarConfig config;
  config.range_sigma_m = 0.0;
  config.dropout = 0.0;
  config.mount_m = {0.1, -0.05, 0.12};
  config.mount_rpy_deg = {2.0, -3.0, 40.0};
  return config;
}

core::RangeScan decoded(const Vlp16Model::Scan& scan, const Vlp16Model& lidar)
{
  const auto observation = mrpt_io::makeVelodyneObservation(1e9, scan.packets, lidar.mount());
  core::RangeScan points;
  std::map<std::string, std::uint64_t> dropped;
  mrpt_io::decodeVelodyne(dynamic_cast<const CObservationVelodyneScan&>(*observation), points,
                          dropped);
  return points;
}

/// Largest and mean distance of the points from the surfaces of the world, each point seen from
/// where the vehicle was when it was measured.
std::pair<double, double> surfaceError(const World& world, const Motion& motion,
                                       const Vlp16Model::Scan& scan, const Vlp16Model& lidar)
{
  const core::RangeScan points = decoded(scan, lidar);
  double worst = 0.0, sum = 0.0;
  for (const core::ScanPoint& point : points.points)
  {
    const Eigen::Isometry3d T_WS = motion.pose(scan.t + point.dt) * lidar.mount();
    const double d = std::abs(world.distance(T_WS * point.p_S.cast<double>(), true));
    worst = std::max(worst, d);
    sum += d;
  }
  EXPECT_GT(points.points.size(), 5000u);
  return {worst, sum / static_cast<double>(points.points.size())};
}

TEST(Vlp16Model, PointsLieOnTheWorld)
{
  const World world = smallForest();
  SteadyMotion still, moving;
  moving.v = {1.2, -0.6, 0.2};
  moving.yaw_rate = 0.8;
  LidarConfig config = exactLidar();
  config.max_range_m = 30.0;
  for (const SteadyMotion* motion : {&still, &moving})
  {
    Vlp16Model lidar(config, 1);
    (void)lidar.nextScan(world, *motion);
    // 2 mm steps of range and 0.01 deg steps of azimuth: about 4 mm at 30 m.
    const auto [worst, mean] = surfaceError(world, *motion, lidar.nextScan(world, *motion), lidar);
    EXPECT_LT(worst, 8e-3);
    EXPECT_LT(mean, 1.5e-3);
  }
}

TEST(Vlp16Model, MotionWithinAScanIsThere)
{
  const World world = smallForest();
  SteadyMotion moving, still;
  moving.v = {1.2, -0.6, 0.2};
  moving.yaw_rate = 0.8;
  LidarConfig config = exactLidar();
  Vlp16Model lidar(config, 1);
  const Vlp16Model::Scan scan = lidar.nextScan(world, moving);
  still.p = moving.p;
  EXPECT_GT(surfaceError(world, still, scan, lidar).first, 0.05)
      << "a scan of a moving sensor, read as if it stood still, must not fit";
}

TEST(Vlp16Model, RangeNoiseHasItsSigma)
{
  const World world = World::of({}, {Box(Vector3d(-50, -50, -1), Vector3d(50, 50, 0))}, false);
  LidarConfig config = exactLidar();
  config.mount_rpy_deg.setZero();
  SteadyMotion still;
  Vlp16Model exact(config, 1);
  config.range_sigma_m = 0.025;
  Vlp16Model noisy(config, 1);
  const auto a = exact.nextScan(world, still), b = noisy.nextScan(world, still);
  double sum = 0.0, squared = 0.0;
  int n = 0;
  for (std::size_t k = 0; k < a.packets.size(); ++k)
    for (int block = 0; block < VelodynePacket::kBlocks; ++block)
      for (int i = 0; i < VelodynePacket::kReturnsPerBlock; ++i)
      {
        const int before = a.packets[k].blocks[block].returns[i].distance;
        const int after = b.packets[k].blocks[block].returns[i].distance;
        if (before == 0) continue;
        ASSERT_GT(after, 0);
        const double error = (after - before) * VelodynePacket::kDistanceUnit;
        sum += error;
        squared += error * error;
        ++n;
      }
  ASSERT_GT(n, 10000);
  EXPECT_NEAR(sum / n, 0.0, 4.0 * 0.025 / std::sqrt(n));
  EXPECT_NEAR(std::sqrt(squared / n), 0.025, 5e-4);
}

TEST(Vlp16Model, DropoutsAndBlindRangeLeaveNoReturn)
{
  const World wall = World::of({},
                               {Box(Vector3d(-9, 3, -50), Vector3d(9, 4, 50)),
                                Box(Vector3d(-9, -0.5, -50), Vector3d(9, -0.3, 50))},
                               false);
  LidarConfig config;
  config.mount_m.setZero();
  config.dropout = 0.2;
  config.range_sigma_m = 0.0;
  SteadyMotion still;
  Vlp16Model with(config, 5);
  config.dropout = 0.0;
  Vlp16Model without(config, 5);
  const core::RangeScan some = decoded(with.nextScan(wall, still), with);
  const core::RangeScan all = decoded(without.nextScan(wall, still), without);
  EXPECT_NEAR(static_cast<double>(some.points.size()) / static_cast<double>(all.points.size()), 0.8,
              0.02);
  for (const core::ScanPoint& p : all.points) EXPECT_GE(p.p_S.norm(), config.min_range_m - 2e-3);
}

TEST(Vlp16Model, PacketsAreThoseOfTheManual)
{
  const World world = smallForest();
  SteadyMotion still;
  Vlp16Model lidar(exactLidar(), 1, 3599.99);
  std::uint32_t clock = 3599990000u;
  for (int k = 0; k < 3; ++k)
  {
    EXPECT_DOUBLE_EQ(lidar.nextScanStart(), k == 0 ? 0.0 : lidar.nextScanStart());
    const double expected_end = lidar.nextScanEnd();
    const Vlp16Model::Scan scan = lidar.nextScan(world, still);
    EXPECT_DOUBLE_EQ(scan.end, expected_end);
    EXPECT_TRUE(scan.packets.size() == 75 || scan.packets.size() == 76) << scan.packets.size();
    for (const VelodynePacket& p : scan.packets)
    {
      EXPECT_EQ(p.model, VelodynePacket::kVlp16);
      EXPECT_EQ(p.return_mode, VelodynePacket::kStrongest);
      const double ahead = std::fmod(3.6e9 + p.microseconds - clock, 3.6e9);
      EXPECT_LE(ahead, 2000.0) << "packet clock";
      clock = p.microseconds;
      for (int b = 0; b < VelodynePacket::kBlocks; ++b)
      {
        EXPECT_EQ(p.blocks[b].header, 0xEEFF);
        EXPECT_LT(p.blocks[b].azimuth, 36000);
        if (b == 0) continue;
        const int gap = (p.blocks[b].azimuth - p.blocks[b - 1].azimuth + 36000) % 36000;
        EXPECT_NEAR(gap, 39.8, 1.0);  // 110.592 us at 10 Hz
      }
    }
  }
  EXPECT_NEAR(lidar.nextScanStart(), 0.3, 1.4e-3);
}

TEST(Vlp16Model, EveryPointOfMrptIsAPointOfOurs)
{
  const World world = smallForest();
  SteadyMotion moving;
  moving.v = {1.0, 0.0, 0.0};
  LidarConfig config = exactLidar();
  config.mount_m.setZero();
  config.mount_rpy_deg.setZero();
  Vlp16Model lidar(config, 1);
  const Vlp16Model::Scan scan = lidar.nextScan(world, moving);
  const auto observation = mrpt_io::makeVelodyneObservation(1e9, scan.packets, lidar.mount());
  auto& velodyne = dynamic_cast<CObservationVelodyneScan&>(*observation);
  CObservationVelodyneScan::TGeneratePointCloudParameters parameters;
  parameters.minDistance = 0.0f;
  parameters.maxDistance = 200.0f;
  velodyne.generatePointCloud(parameters);
  const core::RangeScan ours = decoded(scan, lidar);
  const auto& theirs = velodyne.point_cloud;
  ASSERT_GT(theirs.x.size(), 2000u);
  EXPECT_NEAR(static_cast<double>(theirs.x.size()) / static_cast<double>(ours.points.size()), 0.5,
              0.02);
  // Both in order of firing. MRPT has the rotation rate of a whole packet and cuts where we round:
  // two steps of azimuth.
  std::size_t k = 0;
  for (std::size_t i = 0; i < theirs.x.size(); ++i)
  {
    const Eigen::Vector3f p(theirs.x[i], theirs.y[i], theirs.z[i]);
    const float tolerance = 1e-3f + 3.5e-4f * p.norm();
    while (k < ours.points.size() && (ours.points[k].p_S - p).norm() > tolerance) ++k;
    ASSERT_LT(k, ours.points.size()) << "point " << i << " of MRPT is not among ours";
  }
}

TEST(ImuModel, ErrorsHaveTheirStatistics)
{
  SteadyMotion moving;
  moving.yaw_rate = 0.5;
  ImuConfig config;
  config.accel_walk = config.gyro_walk = 0.0;
  Vector3d bias_squared = Vector3d::Zero();
  double noise_squared = 0.0;
  constexpr int kUnits = 300, kSamples = 200;
  for (int unit = 0; unit < kUnits; ++unit)
  {
    ImuModel imu(config, static_cast<std::uint64_t>(unit));
    Vector3d mean = Vector3d::Zero();
    std::vector<Vector3d> errors;
    for (int k = 0; k < kSamples; ++k)
    {
      const core::ImuSample s = imu.sample(moving, k / config.rate_hz);
      errors.push_back(s.f_B - Vector3d(0.0, 0.0, kGravity));
      mean += errors.back() / kSamples;
    }
    bias_squared += mean.cwiseAbs2();
    for (const Vector3d& e : errors) noise_squared += (e - mean).squaredNorm();
  }
  const double sigma = config.accel_density * std::sqrt(config.rate_hz);
  EXPECT_NEAR(std::sqrt(noise_squared / (3.0 * kUnits * (kSamples - 1))), sigma, 0.01 * sigma);
  for (int i = 0; i < 3; ++i)
    EXPECT_NEAR(std::sqrt(bias_squared[i] / kUnits), config.accel_bias_mps2,
                0.15 * config.accel_bias_mps2);
}

TEST(ImuModel, BiasWalksWithTheRootOfTime)
{
  SteadyMotion still;
  ImuConfig config;
  config.gyro_density = 0.0;
  config.gyro_walk = 1e-3;
  double squared = 0.0;
  constexpr int kUnits = 400;
  for (int unit = 0; unit < kUnits; ++unit)
  {
    ImuModel imu(config, static_cast<std::uint64_t>(unit));
    const Vector3d first = imu.sample(still, 0.0).w_B;
    Vector3d last = first;
    for (int k = 1; k <= 40; ++k) last = imu.sample(still, 0.1 * k).w_B;
    squared += (last - first).squaredNorm() / 3.0;
  }
  EXPECT_NEAR(std::sqrt(squared / kUnits), 1e-3 * 2.0, 2e-4);
}

TEST(GpsModel, SlowErrorDecorrelatesAndWhiteErrorDoesNotStay)
{
  SteadyMotion still;
  GpsConfig config;
  config.sigma_m = config.sigma_up_m = 0.0;
  config.bias_sigma_m = 1.0;
  config.bias_time_s = 10.0;
  double variance = 0.0, covariance = 0.0;
  constexpr int kUnits = 3000;
  for (int unit = 0; unit < kUnits; ++unit)
  {
    GpsModel gps(config, static_cast<std::uint64_t>(unit));
    const Vector3d a = gps.reading(still, 0.0).p_W - still.p;
    const Vector3d b = gps.reading(still, 5.0).p_W - still.p;
    variance += b.x() * b.x() / kUnits;
    covariance += a.x() * b.x() / kUnits;
  }
  EXPECT_NEAR(variance, 1.0, 0.1);
  EXPECT_NEAR(covariance, std::exp(-0.5), 0.1);
}

TEST(GpsModel, DelayShowsThePast)
{
  SteadyMotion moving;
  moving.v = {2.0, 0.0, 0.0};
  GpsConfig config;
  config.sigma_m = config.sigma_up_m = config.bias_sigma_m = config.velocity_sigma_mps = 0.0;
  config.delay_s = 0.2;
  config.lever_m = {0.0, 0.0, 0.3};
  GpsModel gps(config, 1);
  const mrpt_io::GpsReading reading = gps.reading(moving, 3.0);
  EXPECT_TRUE(reading.p_W.isApprox(Vector3d(5.6, 0.0, 1.8)));
  EXPECT_TRUE(reading.lever_B.isApprox(config.lever_m));
}

struct Recording
{
  World world = smallForest();
  ScriptedFlight flight =
      ScriptedFlight::through({{{-19, 0, 2}}, {{-18.5, 0.2, 2}}}, {1.2, 1.0, 0.8, 0.3, 0.2});
  SensorSuite suite;

  std::vector<mrpt::obs::CObservation::Ptr> all(std::uint64_t seed) const
  {
    FlightRecorder recorder(world, flight, flight.duration(), suite, seed);
    std::vector<mrpt::obs::CObservation::Ptr> observations;
    while (auto observation = recorder.next()) observations.push_back(observation);
    return observations;
  }
};

TEST(FlightRecorder, ToldInOrderOfTimeAtTheRatesAskedFor)
{
  const Recording recording;
  std::map<std::string, int> counts;
  mrpt::Clock::time_point last{};
  for (const auto& observation : recording.all(1))
  {
    EXPECT_GE(observation->timestamp, last);
    last = observation->timestamp;
    ++counts[observation->sensorLabel];
  }
  const double duration = recording.flight.duration();
  EXPECT_NEAR(counts["IMU"], 200.0 * duration, 1.1);
  EXPECT_NEAR(counts["VELOCITY"], 50.0 * duration, 1.1);
  EXPECT_NEAR(counts["GROUND_TRUTH"], 50.0 * duration, 1.1);
  EXPECT_NEAR(counts["GPS"], 5.0 * duration, 1.1);
  EXPECT_NEAR(counts["VELODYNE"], 10.0 * duration, 1.1);
  EXPECT_EQ(counts.size(), 5u);
}

TEST(FlightRecorder, SameSeedSameBytesOtherSeedOtherBytes)
{
  const Recording recording;
  const auto a = recording.all(1), b = recording.all(1), c = recording.all(2);
  ASSERT_EQ(a.size(), b.size());
  ASSERT_EQ(a.size(), c.size());
  std::map<std::string, int> changed;
  for (std::size_t k = 0; k < a.size(); ++k)
  {
    ASSERT_EQ(bytesOf(*a[k]), bytesOf(*b[k]));
    if (bytesOf(*a[k]) != bytesOf(*c[k])) ++changed[a[k]->sensorLabel];
  }
  for (const char* label : {"IMU", "VELOCITY", "GPS", "VELODYNE"}) EXPECT_GT(changed[label], 0);
  EXPECT_EQ(changed["GROUND_TRUTH"], 0);
}

TEST(FlightRecorder, RawlogIsByteIdenticalAndReadsBackAsTheTruth)
{
  Recording recording;
  recording.suite.gps.lever_m = {0.0, 0.0, 0.2};
  const test::TempFile one("1.rawlog"), two("2.rawlog");
  for (const auto* file : {&one, &two})
  {
    mrpt_io::RawlogWriter writer(file->path());
    for (const auto& observation : recording.all(3)) writer.write(*observation);
    writer.close();
  }
  EXPECT_EQ(one.content(), two.content());

  mrpt_io::InputConfig config;
  config.datum = "47.3667,8.55,450";
  mrpt_io::ObservationDecoder decoder(config);
  mrpt_io::RawlogReader reader(one.path());
  int truths = 0, fixes = 0, velocities = 0, scans = 0;
  while (const auto observation = reader.next())
  {
    if (const auto truth = decoder.truth(*observation))
    {
      const auto pose = recording.flight.pose(truth->t);
      EXPECT_LT((truth->position - pose.translation()).norm(), 1e-5);
      ++truths;
      continue;
    }
    for (const core::Measurement& m : decoder.decode(*observation))
    {
      const MotionSample now = recording.flight.at(core::timeOf(m));
      if (const auto* fix = std::get_if<core::PositionFix>(&m))
      {
        const Vector3d error = fix->p_W - now.p_W - now.q_WB * fix->lever_B;
        EXPECT_LT(error.cwiseQuotient(fix->sigma).norm(), 6.0);
        EXPECT_NEAR(fix->lever_B.z(), 0.2, 1e-6);
        ++fixes;
      }
      if (const auto* v = std::get_if<core::VelocityFix>(&m); v && v->source == "VELOCITY")
      {
        EXPECT_LT((v->v - now.v_W).norm(), 0.3);
        ++velocities;
      }
      if (const auto* imu = std::get_if<core::ImuSample>(&m))
      {
        const Vector3d force = now.q_WB.conjugate() * (now.a_W + Vector3d(0, 0, kGravity));
        EXPECT_LT((imu->f_B - force).norm(), 0.6);
      }
      if (const auto* scan = std::get_if<core::RangeScan>(&m))
        scans += scan->points.size() > 5000 ? 1 : 0;
    }
  }
  EXPECT_GT(truths, 50);
  EXPECT_GT(fixes, 5);
  EXPECT_GT(velocities, 50);
  EXPECT_GT(scans, 10);
}

TEST(FlightRecorder, OneSensorDoesNotDisturbAnother)
{
  Recording recording;
  const auto a = recording.all(1);
  recording.suite.imu.rate_hz = 100.0;
  recording.suite.lidar.max_range_m = 5.0;
  recording.suite.velocity.sigma_mps = 1.0;
  const auto b = recording.all(1);
  const auto of = [](const auto& all, const char* label)
  {
    std::string bytes;
    for (const auto& o : all)
      if (o->sensorLabel == label) bytes += bytesOf(*o);
    return bytes;
  };
  EXPECT_EQ(of(a, "GPS"), of(b, "GPS"));
  EXPECT_EQ(of(a, "GROUND_TRUTH"), of(b, "GROUND_TRUTH"));
  EXPECT_NE(of(a, "VELOCITY"), of(b, "VELOCITY"));
}

TEST(Forest, IsWhatWasAskedForAndComesFromItsSeed)
{
  ForestConfig config;
  const std::vector<Tree> trees = makeForest(config, 9);
  EXPECT_EQ(trees.size(), 240u);
  for (std::size_t i = 0; i < trees.size(); ++i)
  {
    EXPECT_LE(trees[i].centre_W.cwiseAbs().maxCoeff(), 20.0);
    EXPECT_GE((trees[i].centre_W - Eigen::Vector2d(19.0, 0.0)).norm() - trees[i].radius, 1.5);
    for (std::size_t j = 0; j < i; ++j)
      EXPECT_GE((trees[i].centre_W - trees[j].centre_W).norm() - trees[i].radius - trees[j].radius,
                config.min_gap_m);
  }
  EXPECT_EQ(forestCsv(trees), forestCsv(makeForest(config, 9)));
  EXPECT_NE(forestCsv(trees), forestCsv(makeForest(config, 10)));
  config.density_per_m2 = 2.0;
  EXPECT_THROW((void)makeForest(config, 1), std::invalid_argument);
}
}  // namespace
}  // namespace slalom::simulation
