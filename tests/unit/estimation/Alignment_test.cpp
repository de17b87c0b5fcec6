// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "SimulatedFlight.h"

namespace slalom::test
{
namespace
{
using core::ImuSample;
using estimation::EstimatorStatus;
using estimation::FilterConfig;
using estimation::StateEstimator;

constexpr double kSlack = 0.05;  // [m/s] velocity corrections between two looks
constexpr double kDegree = 3.14159265358979 / 180.0;

double yawError(const StateEstimator& e, const FlightPath& path)
{
  const auto s = e.state();
  return std::abs(core::wrapAngle(s->yaw() - core::yawOf(path.attitude(s->t))));
}

/// The same path, seen in a world turned by `angle`: no heading may be special.
FlightPath turned(const FlightPath& path, double angle)
{
  FlightPath out;
  out.position = [=](double t) -> Eigen::Vector3d
  { return core::fromYaw(angle) * path.position(t); };
  out.yaw = [=](double t) { return path.yaw(t) + angle; };
  return out;
}

struct Case
{
  const char* name;
  double take_off;
  bool velocity;
  bool in_body;
};
}  // namespace

TEST(Alignment, HeadingWithinThreeDegreesAfterTwentySeconds)
{
  const Case cases[] = {{"world velocity, from rest", 1.0, true, false},
                        {"body velocity, from rest", 1.0, true, true},
                        {"world velocity, airborne", -7.0, true, false},
                        {"body velocity, airborne", -7.0, true, true},
                        {"GPS position only, airborne", -7.0, false, false}};
  for (const Case& c : cases)
  {
    SCOPED_TRACE(c.name);
    for (std::uint64_t seed = 1; seed <= 8; ++seed)
    {
      SCOPED_TRACE(seed);
      SensorSuite suite;
      suite.duration = 20.0 + std::max(0.0, c.take_off);
      suite.velocity_hz = c.velocity ? 20.0 : 0.0;
      suite.velocity_in_body = c.in_body;
      // Without a velocity sensor heading, gyroscope bias and tilt have to come out of second
      // differences of positions, which is slower.
      const double bound = c.velocity ? 3.0 * kDegree : 5.0 * kDegree;
      if (!c.velocity) suite.gps_sigma.setConstant(0.1);
      const FlightPath path = turned(FlightPath::loops(c.take_off, 1.5), 0.5 * double(seed));
      StateEstimator estimator({});
      for (const Arrival& a : simulate(path, suite, seed)) feed(estimator, a.measurement);
      ASSERT_TRUE(estimator.state());
      const double sigma = std::sqrt(estimator.state()->covariance(8, 8));
      EXPECT_LT(yawError(estimator, path), bound);
      EXPECT_LT(yawError(estimator, path), 3.5 * sigma);
      EXPECT_LT(sigma, bound);
    }
  }
}

// Slower than walking, accelerations below 0.1 m/s^2: a body velocity still shows the heading; a
// world velocity does not, and then the course is the guess and the variance says so.
TEST(Alignment, SlowFlight)
{
  for (const bool in_body : {true, false})
    for (std::uint64_t seed = 1; seed <= 6; ++seed)
    {
      SCOPED_TRACE(testing::Message() << "in body " << in_body << " seed " << seed);
      SensorSuite suite;
      suite.duration = 40.0;
      suite.velocity_in_body = in_body;
      const FlightPath path = turned(FlightPath::loops(2.0, 0.2), double(seed));
      StateEstimator estimator({});
      for (const Arrival& a : simulate(path, suite, seed)) feed(estimator, a.measurement);
      ASSERT_TRUE(estimator.state());
      const double sigma = std::sqrt(estimator.state()->covariance(8, 8));
      EXPECT_LT(yawError(estimator, path), 3.2 * sigma);
      if (in_body)
      {
        EXPECT_LT(sigma, 8.0 * kDegree);
      }
      else
      {
        EXPECT_GT(sigma, 20.0 * kDegree);
      }
    }
}

TEST(Alignment, YawSourceDecidesAtOnce)
{
  SensorSuite suite;
  suite.duration = 3.0;
  suite.yaw_hz = 5.0;
  const FlightPath path = FlightPath::hover({10.0, -4.0, 30.0}, 2.5);
  StateEstimator estimator({});
  EXPECT_EQ(estimator.status(), EstimatorStatus::Waiting);
  for (const Arrival& a : simulate(path, suite, 1)) feed(estimator, a.measurement);
  EXPECT_EQ(estimator.status(), EstimatorStatus::Running);
  EXPECT_LT(yawError(estimator, path), 6.0 * kDegree);
}

TEST(Alignment, UnknowableHeadingIsReportedAsUnknown)
{
  FilterConfig config;
  config.heading_patience_s = 4.0;
  SensorSuite suite;
  suite.duration = 40.0;
  for (std::uint64_t seed = 1; seed <= 3; ++seed)
  {
    SCOPED_TRACE(seed);
    StateEstimator estimator(config);
    for (const Arrival& a : simulate(FlightPath::hover({1, 2, 3}, 1.0), suite, seed))
    {
      feed(estimator, a.measurement);
      if (a.at > 1.0 && a.at < 4.0)
      {
        ASSERT_EQ(estimator.status(), EstimatorStatus::Aligning);
      }
    }
    ASSERT_TRUE(estimator.state());
    EXPECT_LT((estimator.state()->p_W - Eigen::Vector3d(1, 2, 3)).norm(), 1.0);
    EXPECT_GT(std::sqrt(estimator.state()->covariance(8, 8)), 0.7) << "claims a heading";
  }
}

TEST(Alignment, HeadingIsFoundAfterRunningWithoutOne)
{
  SensorSuite suite;
  suite.duration = 35.0;
  const FlightPath path = turned(FlightPath::loops(15.0), 2.0);
  for (std::uint64_t seed = 1; seed <= 3; ++seed)
  {
    SCOPED_TRACE(seed);
    StateEstimator estimator({});
    std::optional<core::VehicleState> last;
    for (const Arrival& a : simulate(path, suite, seed))
    {
      feed(estimator, a.measurement);
      const auto s = estimator.state();
      if (a.at > 8.0)
      {
        ASSERT_TRUE(s);
      }
      if (s && last)
      {
        const double fastest = std::max(s->v_W.norm(), last->v_W.norm());
        ASSERT_LE((s->p_L - last->p_L).norm(), (fastest + kSlack) * (s->t - last->t));
      }
      last = s;
    }
    EXPECT_LT(yawError(estimator, path), 3.0 * kDegree);
  }
}

TEST(WithoutImu, CourseGivesHeadingAndPositionFollows)
{
  FlightPath path = FlightPath::hover();
  path.position = [](double t)
  { return Eigen::Vector3d(20.0 * std::sin(0.1 * t), 20.0 * std::cos(0.1 * t), 5.0); };
  path.yaw = [](double t) { return -0.1 * t; };
  SensorSuite suite;
  suite.duration = 40.0;
  suite.imu_hz = 0.0;
  suite.gps_sigma.setConstant(0.1);
  for (const bool velocity : {true, false})
  {
    SCOPED_TRACE(velocity);
    suite.velocity_hz = velocity ? 5.0 : 0.0;
    StateEstimator estimator({});
    double squares = 0.0;
    int n = 0;
    for (const Arrival& a : simulate(path, suite, 2))
    {
      feed(estimator, a.measurement);
      if (a.at < 10.0) continue;
      ASSERT_TRUE(estimator.state());
      squares += (estimator.state()->p_W - path.position(a.at)).squaredNorm();
      ++n;
      ASSERT_LT(yawError(estimator, path), 35.0 * kDegree);
    }
    EXPECT_LT(std::sqrt(squares / n), 0.3);
  }
}

TEST(WithoutImu, SlowImuIsNotIntegrated)
{
  SensorSuite suite;
  suite.duration = 30.0;
  suite.imu_hz = 8.6;
  suite.velocity_hz = 5.0;
  const FlightPath path = FlightPath::loops(0.5);
  StateEstimator with({});
  StateEstimator without({});
  for (const Arrival& a : simulate(path, suite, 3))
  {
    feed(with, a.measurement);
    if (!std::holds_alternative<ImuSample>(a.measurement)) feed(without, a.measurement);
  }
  ASSERT_TRUE(with.state() && without.state());
  EXPECT_GT(with.counters().dropped.at("imu_too_slow"), 200u);
  EXPECT_LT((with.state()->p_W - path.position(with.state()->t)).norm(), 1.0);
  EXPECT_LT((with.state()->p_W - without.state()->p_W).norm(), 0.05);
}

TEST(WithoutImu, LossAndReturnOfTheImuInFlight)
{
  SensorSuite suite;
  suite.duration = 40.0;
  suite.yaw_hz = 5.0;
  const FlightPath path = FlightPath::loops(0.5);
  for (std::uint64_t seed = 1; seed <= 5; ++seed)
  {
    SCOPED_TRACE(seed);
    StateEstimator estimator({});
    for (const Arrival& a : simulate(path, suite, seed))
    {
      if (std::holds_alternative<ImuSample>(a.measurement) && a.at > 15.0 && a.at < 22.0) continue;
      feed(estimator, a.measurement);
      if (a.at < 10.0) continue;
      ASSERT_TRUE(estimator.state());
      ASSERT_GT(estimator.state()->t, a.at - 0.2) << "time stands still";
      ASSERT_LT((estimator.state()->p_W - path.position(estimator.state()->t)).norm(), 2.0);
    }
    EXPECT_EQ(estimator.status(), EstimatorStatus::Running);
    EXPECT_LT(estimator.state()->q_WB.angularDistance(path.attitude(estimator.state()->t)), 0.1);
  }
}

TEST(PoseSource, CarriesTheStateAlone)
{
  const FlightPath path = FlightPath::loops(-5.0);
  for (const bool with_imu : {false, true})
  {
    core::Rng rng(4);
    SensorSuite suite;
    suite.duration = 10.0;
    suite.gps_hz = suite.velocity_hz = 0.0;
    suite.imu_hz = with_imu ? 100.0 : 0.0;
    auto flight = simulate(path, suite, 5);
    for (double t = 0.002; t < suite.duration; t += 0.04)
    {
      core::PoseFix fix;
      fix.t = t;
      fix.T_WB = Eigen::Translation3d(path.position(t) + rng.normal3(0.02)) *
                 (core::expSO3(rng.normal3(0.01)) * path.attitude(t));
      flight.push_back({t, fix});
    }
    std::stable_sort(flight.begin(), flight.end(),
                     [](const Arrival& a, const Arrival& b) { return a.at < b.at; });
    StateEstimator estimator({});
    for (const Arrival& a : flight)
    {
      feed(estimator, a.measurement);
      if (a.at < 3.0) continue;
      ASSERT_TRUE(estimator.state());
      const auto e = errorOf(*estimator.state(), path);
      ASSERT_LT(e.head<3>().norm(), 0.12);
      // Standard deviation without IMU: 0.5 m/s per axis, from manoeuvre_noise.
      ASSERT_LT(e.segment<3>(3).norm(), with_imu ? 0.3 : 2.0);
      ASSERT_LT(e.tail<3>().norm(), 0.08);
    }
    EXPECT_EQ(estimator.counters().pose, 250u);
  }
}

}  // namespace slalom::test
