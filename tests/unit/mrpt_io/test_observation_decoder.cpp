// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <mrpt/obs/CObservationComment.h>
#include <mrpt/obs/CObservationGPS.h>
#include <mrpt/obs/CObservationIMU.h>
#include <mrpt/obs/CObservationOdometry.h>
#include <mrpt/obs/CObservationRobotPose.h>

#include <cmath>
#include <limits>

#include "slalom/core/Math.h"
#include "slalom/mrpt_io/Encoders.h"
#include "slalom/mrpt_io/IniDocument.h"
#include "slalom/mrpt_io/ObservationDecoder.h"

using namespace slalom;
using namespace slalom::mrpt_io;

namespace
{
constexpr double kStart = 1.7e9;
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

ObservationPtr imu(double t, const std::string& label = "IMU")
{
  return makeImuObservation(kStart + t, {}, label);
}

std::shared_ptr<mrpt::obs::CObservationGPS> gps(double t, const std::string& label = "GPS")
{
  static const EnuFrame frame({36.8, -2.4, 50.0});
  return std::dynamic_pointer_cast<mrpt::obs::CObservationGPS>(
      makeGpsObservation(kStart + t, {.v_W = {1, 2, 0}}, frame, label));
}

template <class T>
int countOf(const std::vector<core::Measurement>& all)
{
  int n = 0;
  for (const auto& m : all) n += std::holds_alternative<T>(m);
  return n;
}

TEST(ObservationDecoder, TimeStartsAtTheFirstObservationItUnderstands)
{
  ObservationDecoder decoder{InputConfig()};
  EXPECT_EQ(decoder.epoch(), 0.0);
  mrpt::obs::CObservationComment old;
  old.timestamp = mrpt::Clock::fromDouble(kStart - 3e8);
  EXPECT_TRUE(decoder.decode(old).empty());
  EXPECT_EQ(decoder.dropped().at("mrpt::obs::CObservationComment not understood"), 1U);
  EXPECT_EQ(core::timeOf(decoder.decode(*imu(0)).at(0)), 0.0);
  EXPECT_NEAR(core::timeOf(decoder.decode(*imu(2.5)).at(0)), 2.5, 1e-6);
  EXPECT_NEAR(decoder.epoch(), kStart, 1e-6);
}

TEST(ObservationDecoder, DoesNotBelieveSingleTimeJumps)
{
  ObservationDecoder decoder{InputConfig()};
  int used = 0;
  for (int i = 0; i < 100; ++i)
  {
    const double wrong = i == 30 ? 1e8 : i == 60 ? -3600.0 : 0.0;
    used += static_cast<int>(decoder.decode(*imu(0.01 * i + wrong)).size());
  }
  EXPECT_EQ(used, 98);
  EXPECT_EQ(decoder.dropped().at("time jump"), 2U);
}

TEST(ObservationDecoder, AClockThatDisagreesWithTheOthersIsNotUsed)
{
  ObservationDecoder decoder{InputConfig()};
  for (int i = 0; i < 50; ++i)
  {
    EXPECT_EQ(decoder.decode(*imu(0.01 * i)).size(), 1U);
    EXPECT_TRUE(decoder.decode(*gps(0.01 * i + 1e8)).empty());
  }
  EXPECT_EQ(decoder.dropped().at("time jump"), 50U);
}

TEST(ObservationDecoder, APauseOfTheRecordingIsBelievedAfterThreeStamps)
{
  ObservationDecoder decoder{InputConfig()};
  int used = 0;
  for (int i = 0; i < 50; ++i) used += static_cast<int>(decoder.decode(*imu(0.01 * i)).size());
  for (int i = 0; i < 50; ++i)
    used += static_cast<int>(decoder.decode(*imu(600.0 + 0.01 * i)).size());
  EXPECT_EQ(used, 98);
  EXPECT_EQ(decoder.decode(*gps(600.6)).size(), 2U) << "the others follow at once";
  for (int i = 0; i < 20; ++i)
    EXPECT_TRUE(decoder.decode(*imu(0.01 * i)).empty()) << "time never runs back";
}

TEST(ObservationDecoder, MissingStampsAreCounted)
{
  ObservationDecoder decoder{InputConfig()};
  const auto o = imu(0);
  o->timestamp = INVALID_TIMESTAMP;
  EXPECT_TRUE(decoder.decode(*o).empty());
  EXPECT_EQ(decoder.dropped().at("no time stamp"), 1U);
  EXPECT_EQ(decoder.epoch(), 0.0);
}

TEST(ObservationDecoder, LateStampsWithinAMinutePass)
{
  ObservationDecoder decoder{InputConfig()};
  (void)decoder.decode(*imu(10.0));
  const auto late = decoder.decode(*gps(9.5));
  ASSERT_FALSE(late.empty());
  EXPECT_NEAR(core::timeOf(late[0]), -0.5, 1e-6);
}

TEST(ObservationDecoder, RefusesFixesThatAreNone)
{
  using mrpt::obs::gnss::Message_NMEA_GGA;
  const auto refused = [](auto change) -> std::string
  {
    ObservationDecoder decoder{InputConfig()};
    const auto o = gps(0);
    auto& fields = o->getMsgByClass<Message_NMEA_GGA>().fields;
    change(fields);
    EXPECT_TRUE(decoder.decode(*o).empty());
    EXPECT_FALSE(decoder.datum().has_value()) << "a refused fix must not become the datum";
    return decoder.dropped().empty() ? "" : decoder.dropped().begin()->first;
  };
  EXPECT_EQ(refused([](auto& f) { f.fix_quality = 0; }), "GPS without fix");
  EXPECT_EQ(refused([](auto& f) { f.latitude_degrees = f.longitude_degrees = 0.0; }), "GPS at 0,0");
  EXPECT_EQ(refused([](auto& f) { f.latitude_degrees = kNan; }), "GPS not finite");
  EXPECT_EQ(refused([](auto& f) { f.altitude_meters = kNan; }), "GPS not finite");
  EXPECT_EQ(refused([](auto& f) { f.latitude_degrees = 91.0; }), "GPS outside the earth's surface");

  ObservationDecoder decoder{InputConfig()};
  const auto rmc_only = gps(0);
  rmc_only->messages.erase(mrpt::obs::gnss::NMEA_GGA);
  EXPECT_TRUE(decoder.decode(*rmc_only).empty());
  EXPECT_EQ(decoder.dropped().at("GPS without GGA"), 1U);
}

TEST(ObservationDecoder, TheFirstFixIsTheDatumAndSpeedNeedsAValidRmc)
{
  using mrpt::obs::gnss::Message_NMEA_RMC;
  ObservationDecoder decoder{InputConfig()};
  const auto first = decoder.decode(*gps(0));
  ASSERT_EQ(first.size(), 2U);
  EXPECT_LT(std::get<core::PositionFix>(first[0]).p_W.norm(), 1e-6);
  EXPECT_LT((std::get<core::VelocityFix>(first[1]).v - Eigen::Vector3d(1, 2, 0)).norm(), 1e-9);
  ASSERT_TRUE(decoder.datum().has_value());
  EXPECT_LT((*decoder.datum() - Eigen::Vector3d(36.8, -2.4, 50.0)).norm(), 1e-6);
  const auto invalid = gps(1);
  invalid->getMsgByClass<Message_NMEA_RMC>().fields.validity_char = 'V';
  EXPECT_EQ(decoder.decode(*invalid).size(), 1U);
}

TEST(ObservationDecoder, MalformedDatumsAreConfigErrors)
{
  for (const char* bad : {"1,2", "a,b,c", "91,0,0", "0,400,0", "1;2;3"})
  {
    InputConfig config;
    config.datum = bad;
    EXPECT_THROW(ObservationDecoder{config}, ConfigError) << bad;
  }
}

TEST(ObservationDecoder, LabelsChooseReceiversAndPoses)
{
  InputConfig config;
  config.gps_labels = "LEFT, REAR";
  config.pose_labels = "MOCAP,ODO";
  config.truth_label = "TRUTH";
  ObservationDecoder decoder(config);
  EXPECT_EQ(decoder.decode(*gps(0, "LEFT")).size(), 2U);
  EXPECT_EQ(decoder.decode(*gps(0, "REAR")).size(), 2U);
  EXPECT_TRUE(decoder.decode(*gps(0, "RIGHT")).empty());
  EXPECT_EQ(decoder.dropped().at("GPS label not wanted"), 1U);

  EXPECT_EQ(decoder.decode(*makePoseObservation(kStart, {}, "MOCAP")).size(), 1U);
  EXPECT_TRUE(decoder.decode(*makePoseObservation(kStart, {}, "SLAM")).empty());
  const auto truth = makePoseObservation(kStart, {}, "TRUTH");
  EXPECT_TRUE(decoder.decode(*truth).empty());
  EXPECT_TRUE(decoder.truth(*truth).has_value());
  EXPECT_FALSE(decoder.truth(*makePoseObservation(kStart, {}, "MOCAP")).has_value());
  EXPECT_EQ(decoder.dropped().size(), 2U) << "truth is not counted as dropped";
}

TEST(ObservationDecoder, OdometryGivesPlanarVelocityAndAPoseOnRequest)
{
  mrpt::obs::CObservationOdometry o;
  o.timestamp = mrpt::Clock::fromDouble(kStart);
  o.sensorLabel = "ODO";
  o.odometry = mrpt::poses::CPose2D(1, 2, 0.5);
  ObservationDecoder plain{InputConfig()};
  EXPECT_TRUE(plain.decode(o).empty());
  o.hasVelocities = true;
  o.velocityLocal = {1.5, -0.5, 0.1};
  const auto out = plain.decode(o);
  ASSERT_EQ(out.size(), 1U);
  const auto& v = std::get<core::VelocityFix>(out[0]);
  EXPECT_TRUE(v.in_body);
  EXPECT_EQ(v.v, Eigen::Vector3d(1.5, -0.5, 0.0));
  EXPECT_TRUE(std::isinf(v.sigma.z()));

  InputConfig config;
  config.pose_labels = "ODO";
  ObservationDecoder wanted(config);
  const auto both = wanted.decode(o);
  ASSERT_EQ(both.size(), 2U);
  const auto& pose = std::get<core::PoseFix>(both[1]);
  EXPECT_EQ(pose.T_WB.translation(), Eigen::Vector3d(1, 2, 0));
  EXPECT_NEAR(core::yawOf(Eigen::Quaterniond(pose.T_WB.linear())), 0.5, 1e-12);
}

TEST(ObservationDecoder, PosesWithoutCovarianceKeepTheDefaults)
{
  for (const double diagonal : {0.0, 1.0})
  {
    mrpt::obs::CObservationRobotPose o;
    o.timestamp = mrpt::Clock::fromDouble(kStart);
    for (int i = 0; i < 6; ++i) o.pose.cov(i, i) = diagonal;
    ObservationDecoder decoder{InputConfig()};
    const auto fix = std::get<core::PoseFix>(decoder.decode(o).at(0));
    EXPECT_EQ(fix.sigma_position, core::PoseFix().sigma_position);
    EXPECT_EQ(fix.sigma_rotation, core::PoseFix().sigma_rotation);
  }
}

TEST(ObservationDecoder, NumbersThatAreNoneNeverPass)
{
  ObservationDecoder decoder{InputConfig()};
  EXPECT_TRUE(decoder.decode(*makeImuObservation(kStart, {0.0, {kNan, 0, 0}, {}})).empty());
  EXPECT_TRUE(decoder.decode(*makeVelocityObservation(kStart, {0, INFINITY, 0})).empty());
  mrpt::obs::CObservationOdometry o;
  o.timestamp = mrpt::Clock::fromDouble(kStart);
  o.hasVelocities = true;
  o.velocityLocal = {kNan, 0, 0};
  EXPECT_TRUE(decoder.decode(o).empty());
  mrpt::obs::CObservationRobotPose pose;
  pose.timestamp = o.timestamp;
  pose.pose.mean.x(kNan);
  EXPECT_TRUE(decoder.decode(pose).empty());
  EXPECT_EQ(decoder.dropped().at("IMU not finite"), 2U);
  EXPECT_EQ(decoder.dropped().at("odometry not finite"), 1U);
  EXPECT_EQ(decoder.dropped().at("pose not finite"), 1U);
}

TEST(ObservationDecoder, AnImuWithHalfOfItsDataIsCounted)
{
  mrpt::obs::CObservationIMU o;
  o.timestamp = mrpt::Clock::fromDouble(kStart);
  o.set(mrpt::obs::IMU_X_ACC, 1.0);
  o.set(mrpt::obs::IMU_WX, 1.0);
  ObservationDecoder decoder{InputConfig()};
  EXPECT_TRUE(decoder.decode(o).empty());
  EXPECT_EQ(decoder.dropped().at("IMU without acceleration and rate"), 1U);
}
}  // namespace
