// SPDX-License-Identifier: BSD-3-Clause
/** Sensors that see only a part, lose what they said, or are off. */
#include <gtest/gtest.h>
#include <mrpt/obs/CObservation.h>
#include <mrpt/obs/CObservationVelodyneScan.h>

#include <cmath>
#include <map>
#include <numbers>
#include <vector>

#include "Observations.h"
#include "slalom/mrpt_io/Encoders.h"
#include "slalom/mrpt_io/ObservationDecoder.h"
#include "slalom/mrpt_io/Velodyne.h"
#include "slalom/simulation/FlightRecorder.h"
#include "slalom/simulation/ScriptedFlight.h"

namespace slalom::simulation
{
namespace
{
using Eigen::Vector3d;
using mrpt_io::VelodynePacket;

struct Hover : Motion
{
  MotionSample at(double) const override
  {
    MotionSample m;
    m.p_W = {0.0, 0.0, 1.5};
    return m;
  }
  Eigen::Isometry3d pose(double) const override
  {
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    T.translation() = Vector3d(0.0, 0.0, 1.5);
    return T;
  }
};

World room()
{
  // Four walls, 4 m away.
  return World::of(
      {},
      {Box(Vector3d(4, -5, 0), Vector3d(5, 5, 6)), Box(Vector3d(-5, -5, 0), Vector3d(-4, 5, 6)),
       Box(Vector3d(-5, 4, 0), Vector3d(5, 5, 6)), Box(Vector3d(-5, -5, 0), Vector3d(5, -4, 6))},
      true);
}

/// Azimuths (counter-clockwise, [rad]) and ranges [m] of all returns.
std::vector<std::pair<double, double>> returnsOf(const Vlp16Model::Scan& scan)
{
  std::vector<std::pair<double, double>> returns;
  for (const VelodynePacket& packet : scan.packets)
    for (const auto& block : packet.blocks)
      for (const auto& r : block.returns)
        if (r.distance > 0)
          returns.emplace_back(
              std::remainder(-block.azimuth * std::numbers::pi / 18000.0, 2.0 * std::numbers::pi),
              r.distance * VelodynePacket::kDistanceUnit);
  return returns;
}

TEST(Vlp16Model, SeesWhatItsFieldOfViewHolds)
{
  const World world = room();
  std::map<double, std::size_t> counts;
  for (const double fov : {360.0, 180.0, 90.0, 30.0})
  {
    LidarConfig config;
    config.dropout = 0.0;
    config.fov_deg = fov;
    const auto returns = returnsOf(Vlp16Model(config, 1).nextScan(world, Hover{}));
    counts[fov] = returns.size();
    // A block holds two firings, that is 0.4 deg.
    for (const auto& [azimuth, range] : returns)
      ASSERT_LE(std::abs(azimuth), (0.5 * fov + 0.5) * std::numbers::pi / 180.0);
  }
  ASSERT_GT(counts[360.0], 25000u);
  constexpr double kPacket = 384.0;  // rays; whole packets go a little beyond one revolution
  for (const double fov : {180.0, 90.0, 30.0})
    EXPECT_NEAR(static_cast<double>(counts[fov]), static_cast<double>(counts[360.0]) * fov / 360.0,
                kPacket);
}

/// Not to look is not to see nothing: only firings that looked into the open are told as silent.
TEST(Vlp16Model, SaysNothingOfWhatItsFieldOfViewDoesNotHold)
{
  Shapes nothing;
  nothing.ground = false;
  const World open = World::of(std::move(nothing));
  for (const double fov : {360.0, 90.0, 4.0})
  {
    SCOPED_TRACE(fov);
    LidarConfig config;
    config.fov_deg = fov;
    Vlp16Model lidar(config, 1);
    (void)lidar.nextScan(open, Hover{});
    const auto scan = lidar.nextScan(open, Hover{});
    const auto observation = mrpt_io::makeVelodyneObservation(0.0, scan.packets, lidar.mount());
    core::RangeScan decoded;
    std::map<std::string, std::uint64_t> dropped;
    mrpt_io::decodeVelodyne(dynamic_cast<const mrpt::obs::CObservationVelodyneScan&>(*observation),
                            decoded, dropped);
    EXPECT_TRUE(decoded.points.empty());
    ASSERT_FALSE(decoded.silent.empty());
    for (const core::ScanPoint& ray : decoded.silent)
      ASSERT_LE(std::abs(std::atan2(ray.p_S.y(), ray.p_S.x())),
                (0.5 * fov + 0.5) * std::numbers::pi / 180.0);
  }
}

/// Rays at their own time: a ball that comes nearer is nearer in the packets that were fired later.
TEST(Vlp16Model, SeesMoversWhereTheyAreWhenTheRayIsFired)
{
  Shapes shapes;
  Mover ball;
  ball.radius = 1.0;
  ball.path.start_W = {10.0, 0.0, 1.6};  // in front of the sensor, 0.1 m above the body
  ball.path.velocity_W = {-5.0, 0.0, 0.0};
  shapes.movers = {ball};
  shapes.ground = false;
  const World world = World::of(std::move(shapes));
  LidarConfig config;
  config.dropout = config.range_sigma_m = 0.0;
  Vlp16Model lidar(config, 1);
  for (int scan = 0; scan < 8; ++scan)
  {
    const auto seen = lidar.nextScan(world, Hover{});
    double nearest = 1e9;
    for (const auto& [azimuth, range] : returnsOf(seen)) nearest = std::min(nearest, range);
    // Straight ahead is azimuth 0: fired at the beginning and at the end of the revolution.
    EXPECT_GE(nearest, 9.0 - 5.0 * seen.end - 5e-3);
    EXPECT_LE(nearest, 9.0 - 5.0 * seen.t + 0.05);
    EXPECT_LT(nearest, 9.0 - 5.0 * seen.t - 0.3) << "the later rays see it nearer";
  }
}

std::map<std::string, std::vector<double>> timesOf(const SensorSuite& suite)
{
  static const World world = room();
  const Hover hover;
  FlightRecorder recorder(world, hover, 4.0, suite, 1);
  std::map<std::string, std::vector<double>> times;
  while (const auto observation = recorder.next())
    times[observation->sensorLabel].push_back(mrpt::Clock::toDouble(observation->timestamp) -
                                              suite.record.epoch_s);
  return times;
}

TEST(FlightRecorder, IsSilentInAnOutageAndTheSameElsewhere)
{
  SensorSuite whole;
  whole.lidar.fov_deg = 30.0;
  SensorSuite gaps = whole;
  gaps.lidar.outage_start_s = gaps.gps.outage_start_s = gaps.velocity.outage_start_s = 1.05;
  gaps.lidar.outage_s = gaps.gps.outage_s = gaps.velocity.outage_s = 1.2;
  auto all = timesOf(whole), some = timesOf(gaps);
  for (const std::string label : {"VELODYNE", "GPS", "VELOCITY", "IMU", "GROUND_TRUTH"})
  {
    SCOPED_TRACE(label);
    std::vector<double> expected;
    const bool silent = label == "VELODYNE" || label == "GPS" || label == "VELOCITY";
    for (const double t : all[label])
      if (!silent || t < 1.05 - 1e-6 || t > 2.25 - 1e-6) expected.push_back(t);
    EXPECT_EQ(some[label], expected);
    EXPECT_EQ(silent, expected.size() < all[label].size());
  }
}

/// Errors of the fixes at a vehicle that hovers.
std::vector<Vector3d> errorsOf(const GpsConfig& config, double duration, std::uint64_t seed)
{
  GpsModel gps(config, seed);
  std::vector<Vector3d> errors;
  for (double t = 0.0; t < duration; t += 1.0 / config.rate_hz)
    errors.push_back(gps.reading(Hover{}, t).p_W - Vector3d(0.0, 0.0, 1.5));
  return errors;
}

GpsConfig exactGps()
{
  GpsConfig config;
  config.sigma_m = config.sigma_up_m = config.bias_sigma_m = config.velocity_sigma_mps = 0.0;
  return config;
}

TEST(GpsModel, JumpsAndWalksAway)
{
  GpsConfig jump = exactGps();
  jump.jump_time_s = 3.0;
  jump.jump_m = {2.0, -1.0, 0.5};
  const auto jumped = errorsOf(jump, 6.0, 1);
  EXPECT_LT(jumped[14].norm(), 1e-12);
  EXPECT_LT((jumped[16] - jump.jump_m).norm(), 1e-12);

  GpsConfig walk = exactGps();
  walk.bias_walk = 0.1;
  // Variance walk^2 t, over 200 walks of 25 s: sigma 0.5 m to 5 %.
  double square = 0.0;
  for (std::uint64_t seed = 1; seed <= 200; ++seed)
  {
    const auto errors = errorsOf(walk, 25.2, seed);
    square += errors[125].head<2>().squaredNorm() / 400.0;
  }
  EXPECT_NEAR(std::sqrt(square), 0.5, 0.08);
}
}  // namespace
}  // namespace slalom::simulation
