// SPDX-License-Identifier: BSD-3-Clause
// Law: what the encoders write, the decoder reads back, through a file.
#include <gtest/gtest.h>

#include "Rawlogs.h"
#include "slalom/core/Math.h"
#include "slalom/core/Rng.h"
#include "slalom/mrpt_io/Encoders.h"
#include "slalom/mrpt_io/ObservationDecoder.h"
#include "slalom/mrpt_io/RawlogWriter.h"

using namespace slalom;
using namespace slalom::mrpt_io;

namespace
{
constexpr double kStart = 1.7e9 + 0.25;
constexpr double kTick = 2e-6;  // [s] double seconds of today resolve 0.24 us

Eigen::Isometry3d anyPose(core::Rng& rng)
{
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = core::expSO3(rng.normal3(1.0)).toRotationMatrix();
  T.translation() = rng.normal3(20.0);
  return T;
}

/// Sends one observation through a file and a fresh decoder whose epoch is kStart.
std::vector<core::Measurement> through(const ObservationPtr& observation,
                                       InputConfig config = InputConfig(),
                                       std::optional<core::TimedPose>* truth = nullptr)
{
  const test::TempFolder folder;
  RawlogWriter writer(folder.path() / "a.rawlog");
  writer.write(*observation);
  writer.close();
  RawlogReader reader(folder.path() / "a.rawlog");
  ObservationDecoder decoder(config);
  EXPECT_EQ(decoder.logTime(mrpt::Clock::fromDouble(kStart)), 0.0);
  const auto read = reader.next();
  if (truth) *truth = decoder.truth(*read);
  return decoder.decode(*read);
}

TEST(RoundTrip, Imu)
{
  for (std::uint64_t seed = 1; seed <= 20; ++seed)
  {
    SCOPED_TRACE(seed);
    core::Rng rng(seed);
    const core::ImuSample sample{0.0, rng.normal3(10.0), rng.normal3(2.0)};
    const auto out = through(makeImuObservation(kStart + 1.5, sample, "IMU", anyPose(rng)));
    ASSERT_EQ(out.size(), 1U);
    const auto& back = std::get<core::ImuSample>(out[0]);
    EXPECT_NEAR(back.t, 1.5, kTick);
    EXPECT_LT((back.f_B - sample.f_B).norm(), 1e-12);
    EXPECT_LT((back.w_B - sample.w_B).norm(), 1e-12);
  }
}

TEST(RoundTrip, VelocityHasThreeAxesInTheWorld)
{
  core::Rng rng(1);
  const Eigen::Vector3d v_W = rng.normal3(3.0);
  InputConfig config;
  config.velocity_sigma_mps = 0.3;
  const auto out = through(makeVelocityObservation(kStart, v_W), config);
  ASSERT_EQ(out.size(), 1U);
  const auto& back = std::get<core::VelocityFix>(out[0]);
  EXPECT_EQ(back.v, v_W);
  EXPECT_FALSE(back.in_body);
  EXPECT_EQ(back.sigma, Eigen::Vector3d::Constant(0.3));
  EXPECT_EQ(back.source, "VELOCITY");
}

TEST(RoundTrip, Gps)
{
  for (std::uint64_t seed = 1; seed <= 100; ++seed)
  {
    SCOPED_TRACE(seed);
    core::Rng rng(seed);
    const EnuFrame frame(
        {rng.uniform(-80.0, 80.0), rng.uniform(-180.0, 180.0), rng.uniform(0.0, 3000.0)});
    GpsReading reading;
    reading.p_W = rng.normal3(500.0);
    reading.v_W = rng.normal3(5.0);
    const GpsFix kinds[] = {GpsFix::Single, GpsFix::Differential, GpsFix::RtkFixed,
                            GpsFix::RtkFloat};
    reading.fix = kinds[rng.integer(0, 3)];
    reading.sigma = gpsSigmaPerHdop(static_cast<int>(reading.fix)) * rng.uniform(0.2, 5.0);
    reading.lever_B = rng.normal3(0.2);

    InputConfig config;
    const Eigen::IOFormat comma(17, Eigen::DontAlignCols, ",", ",");
    std::ostringstream datum;
    datum << frame.datum().transpose().format(comma);
    config.datum = datum.str();
    config.gps_delay_s = 0.1;
    const auto out = through(makeGpsObservation(kStart + 2.0, reading, frame, "G"), config);
    ASSERT_EQ(out.size(), 2U);
    const auto& position = std::get<core::PositionFix>(out[0]);
    EXPECT_NEAR(position.t, 1.9, kTick);
    EXPECT_LT((position.p_W - reading.p_W).norm(), 1e-5);
    EXPECT_NEAR(position.sigma.x(), reading.sigma, 1e-6 * reading.sigma);
    EXPECT_GE(position.sigma.z(), position.sigma.x());
    EXPECT_LT((position.lever_B - reading.lever_B).norm(), 1e-12);
    EXPECT_EQ(position.source, "G");
    const auto& velocity = std::get<core::VelocityFix>(out[1]);
    EXPECT_LT((velocity.v.head<2>() - reading.v_W.head<2>()).norm(), 1e-9);
    EXPECT_TRUE(std::isinf(velocity.sigma.z()));
    EXPECT_FALSE(velocity.in_body);
  }
}

TEST(RoundTrip, PoseAndTruth)
{
  core::Rng rng(3);
  core::PoseFix pose;
  pose.T_WB = anyPose(rng);
  pose.sigma_position = 0.3;
  pose.sigma_rotation = 0.07;
  const auto out = through(makePoseObservation(kStart + 1.0, pose, "MOCAP"));
  ASSERT_EQ(out.size(), 1U);
  const auto& back = std::get<core::PoseFix>(out[0]);
  EXPECT_LT((back.T_WB.matrix() - pose.T_WB.matrix()).norm(), 1e-9);
  EXPECT_NEAR(back.sigma_position, 0.3, 1e-9);
  EXPECT_NEAR(back.sigma_rotation, 0.07, 1e-9);

  std::optional<core::TimedPose> truth;
  EXPECT_TRUE(through(makePoseObservation(kStart + 1.0, pose, "GROUND_TRUTH"), {}, &truth).empty());
  ASSERT_TRUE(truth.has_value());
  EXPECT_NEAR(truth->t, 1.0, kTick);
  EXPECT_LT((truth->position - pose.T_WB.translation()).norm(), 1e-9);
  EXPECT_LT((truth->orientation.toRotationMatrix() - pose.T_WB.linear()).norm(), 1e-9);
}

TEST(RoundTrip, VelodyneKeepsPacketsAndMount)
{
  core::Rng rng(4);
  std::vector<VelodynePacket> packets(5);
  int returns = 0;
  for (auto& packet : packets)
  {
    packet = VelodynePacket();
    packet.model = VelodynePacket::kVlp16;
    packet.return_mode = VelodynePacket::kStrongest;
    for (auto& block : packet.blocks)
    {
      block.header = 0xEEFF;
      for (auto& r : block.returns)
      {
        r.distance = static_cast<std::uint16_t>(rng.integer(0, 3) * 1000);
        returns += r.distance > 0;
      }
    }
  }
  const Eigen::Isometry3d T_BS = anyPose(rng);
  const auto out = through(makeVelodyneObservation(kStart, packets, T_BS, "LIDAR"));
  ASSERT_EQ(out.size(), 1U);
  const auto& scan = std::get<core::RangeScan>(out[0]);
  EXPECT_EQ(static_cast<int>(scan.points.size()), returns);
  EXPECT_LT((scan.T_BS.matrix() - T_BS.matrix()).norm(), 1e-6);
  EXPECT_EQ(scan.label, "LIDAR");
}
}  // namespace
