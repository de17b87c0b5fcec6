// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <limits>

#include "SimulatedFlight.h"

namespace slalom::test
{
namespace
{
using core::ImuSample;
using core::PositionFix;
using core::VelocityFix;
using estimation::EstimatorStatus;
using estimation::FilterConfig;
using estimation::StateEstimator;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

constexpr double kSlack = 0.05;  // [m/s] velocity corrections between two looks

double positionError(const StateEstimator& e, const FlightPath& path)
{
  return (e.state()->p_W - path.position(e.state()->t)).norm();
}

template <class T>
bool is(const Arrival& a)
{
  return std::holds_alternative<T>(a.measurement);
}
}  // namespace

TEST(Outage, TenSecondsWithVelocityDriftLittle)
{
  const FlightPath path = FlightPath::loops(0.5);
  for (const bool in_body : {false, true})
    for (std::uint64_t seed = 1; seed <= 8; ++seed)
    {
      SCOPED_TRACE(seed);
      SensorSuite suite;
      suite.duration = 30.0;
      suite.gps_sigma.setConstant(0.1);
      suite.velocity_in_body = in_body;
      StateEstimator estimator({});
      double worst = 0.0;
      for (const Arrival& a : simulate(path, suite, seed))
      {
        if (is<PositionFix>(a) && a.at > 20.0) continue;
        feed(estimator, a.measurement);
        // 0.1 m/s of drift on top of what was not known when the outage began.
        if (a.at > 20.5)
          worst = std::max(worst, (positionError(estimator, path) - 0.15) / (a.at - 20.0));
      }
      EXPECT_LT(worst, 0.1);
      EXPECT_EQ(estimator.status(), EstimatorStatus::Running);
    }
}

TEST(Outage, TenSecondsOfInertialOnlyStaysHonest)
{
  const FlightPath path = FlightPath::loops(0.5);
  for (std::uint64_t seed = 1; seed <= 8; ++seed)
  {
    SCOPED_TRACE(seed);
    SensorSuite suite;
    suite.duration = 30.0;
    StateEstimator estimator({});
    for (const Arrival& a : simulate(path, suite, seed))
      if (is<ImuSample>(a) || a.at < 20.0) feed(estimator, a.measurement);
    EXPECT_EQ(estimator.status(), EstimatorStatus::DeadReckoning);
    const auto s = estimator.state();
    const Eigen::Vector3d sigma = s->covariance.diagonal().head<3>().cwiseSqrt();
    const Eigen::Vector3d error = s->p_W - path.position(s->t);
    EXPECT_LT(error.norm(), 15.0);
    for (int i = 0; i < 3; ++i) EXPECT_LT(std::abs(error[i]), 4.0 * sigma[i]);
  }
}

TEST(Gate, OutlierOfTwentyMetresIsRejected)
{
  const FlightPath path = FlightPath::loops(0.5);
  for (std::uint64_t seed = 1; seed <= 10; ++seed)
  {
    SCOPED_TRACE(seed);
    core::Rng rng(seed);
    StateEstimator clean({});
    StateEstimator spoilt({});
    for (const Arrival& a : simulate(path, {}, seed))
    {
      feed(clean, a.measurement);
      Arrival b = a;
      auto* fix = std::get_if<PositionFix>(&b.measurement);
      if (fix && fix->t > 10.0 && fix->t < 10.1) fix->p_W += 20.0 * rng.direction();
      feed(spoilt, b.measurement);
    }
    ASSERT_TRUE(spoilt.state());
    EXPECT_EQ(
        spoilt.counters().dropped.at("gated"),
        (clean.counters().dropped.contains("gated") ? clean.counters().dropped.at("gated") : 0u) +
            1u);
    EXPECT_LT((clean.state()->p_W - spoilt.state()->p_W).norm(), 0.1);
  }
}

TEST(Gate, SourceIsBelievedAfterMaxRejects)
{
  const FlightPath path = FlightPath::loops(0.5);
  FilterConfig config;
  config.max_rejects = 10;
  SensorSuite suite;
  suite.duration = 30.0;
  StateEstimator estimator(config);
  const Eigen::Vector3d jump(30.0, -10.0, 5.0);
  int after = 0;
  for (Arrival a : simulate(path, suite, 5))
  {
    auto* fix = std::get_if<PositionFix>(&a.measurement);
    if (fix && a.at > 15.0)
    {
      fix->p_W += jump;
      ++after;
    }
    feed(estimator, a.measurement);
    if (a.at < 12.0) continue;
    const Eigen::Vector3d error = estimator.state()->p_W - path.position(estimator.state()->t);
    if (after < config.max_rejects)
    {
      ASSERT_LT(error.norm(), 2.0) << "followed too early";
    }
    if (after > config.max_rejects)
    {
      ASSERT_LT((error - jump).norm(), 2.5) << "never followed";
    }
  }
  EXPECT_EQ(estimator.counters().resets, 1u);
}

TEST(Gate, EachReceiverHasItsOwnMemory)
{
  const FlightPath path = FlightPath::loops(0.5);
  StateEstimator estimator({});
  for (const Arrival& a : simulate(path, {}, 6))
  {
    feed(estimator, a.measurement);
    const auto* fix = std::get_if<PositionFix>(&a.measurement);
    if (!fix || fix->t < 10.0 || fix->t > 12.0) continue;
    // A second receiver that is wrong, but not for long enough to be believed.
    PositionFix other = *fix;
    other.source = "liar";
    other.p_W.x() += 50.0;
    estimator.add(other);
  }
  EXPECT_EQ(estimator.counters().resets, 0u);
  EXPECT_GE(estimator.counters().dropped.at("gated"), 9u);
  EXPECT_LT(positionError(estimator, path), 1.5);
}

TEST(LocalFrame, JumpOfGpsMovesTheWorldPositionOnly)
{
  const FlightPath path = FlightPath::loops(0.5);
  SensorSuite suite;
  suite.duration = 40.0;
  suite.gps_delay = 0.2;
  suite.gps_sigma.setConstant(0.3);
  for (const bool with_velocity : {true, false})
  {
    suite.velocity_hz = with_velocity ? 20.0 : 0.0;
    StateEstimator estimator({});
    std::optional<core::VehicleState> last;
    double largest_world_step = 0.0;
    for (Arrival a : simulate(path, suite, 8))
    {
      auto* fix = std::get_if<PositionFix>(&a.measurement);
      if (fix && fix->t > 20.0) fix->p_W.x() += 2.0;
      feed(estimator, a.measurement);
      const auto s = estimator.state();
      if (!s) continue;
      if (!last)
      {
        EXPECT_EQ(s->p_L, Eigen::Vector3d::Zero());
      }
      if (last)
      {
        const double dt = s->t - last->t;
        const double fastest = std::max(s->v_W.norm(), last->v_W.norm());
        ASSERT_LE((s->p_L - last->p_L).norm(), (fastest + kSlack) * dt + 1e-12) << "t " << s->t;
        largest_world_step = std::max(largest_world_step, (s->p_W - last->p_W).norm());
        // The told past does not change either.
        const auto again = estimator.stateAt(last->t);
        ASSERT_TRUE(again);
        ASSERT_LT((again->p_L - last->p_L).norm(), 1e-9);
      }
      last = s;
    }
    const double expected = 2.0;
    const Eigen::Vector3d shift = last->p_W - path.position(last->t);
    EXPECT_NEAR(shift.x(), expected, 1.0) << "the jump must arrive in W";
    EXPECT_GT(largest_world_step, with_velocity ? 0.3 : 0.05);
  }
}

TEST(BadInput, NonFiniteAndWildValuesAreDroppedAndCounted)
{
  const FlightPath path = FlightPath::loops(0.5);
  StateEstimator estimator({});
  StateEstimator clean({});
  const double inf = std::numeric_limits<double>::infinity();
  for (const Arrival& a : simulate(path, {}, 9))
  {
    feed(estimator, a.measurement);
    feed(clean, a.measurement);
    if (!is<PositionFix>(a)) continue;
    const double t = a.at;
    estimator.add(ImuSample{t, {kNan, 0, 0}, {0, 0, 0}});
    estimator.add(ImuSample{t, {0, 0, 1e6}, {0, 0, 0}});
    estimator.add(ImuSample{kNan, {0, 0, 9.8}, {0, 0, 0}});
    estimator.add(PositionFix{t, {inf, 0, 0}, {1, 1, 1}, {0, 0, 0}, "gps"});
    estimator.add(PositionFix{t, {1e9, 0, 0}, {1, 1, 1}, {0, 0, 0}, "gps"});
    estimator.add(PositionFix{t, {0, 0, 0}, {kNan, 1, 1}, {0, 0, 0}, "gps"});
    estimator.add(PositionFix{t, {0, 0, 0}, {-1, 1, 1}, {0, 0, 0}, "gps"});
    estimator.add(PositionFix{t + 1e6, {0, 0, 0}, {1, 1, 1}, {0, 0, 0}, "gps"});
    estimator.add(VelocityFix{t, {kNan, 0, 0}, {1, 1, 1}, false, "v"});
    estimator.add(VelocityFix{t, {1e4, 0, 0}, {1, 1, 1}, false, "v"});
    estimator.add(core::YawFix{t, kNan, 0.1, "y"});
    core::PoseFix pose;
    pose.t = t;
    pose.T_WB.matrix()(0, 0) = 7.0;
    estimator.add(pose);
  }
  EXPECT_EQ(estimator.state()->p_W, clean.state()->p_W);
  EXPECT_EQ(estimator.state()->covariance, clean.state()->covariance);
  const auto& dropped = estimator.counters().dropped;
  EXPECT_GE(dropped.at("non_finite"), 5u * 95u);
  EXPECT_GE(dropped.at("out_of_range"), 4u * 95u);
  EXPECT_GE(dropped.at("bad_sigma"), 2u * 95u);
  EXPECT_GE(dropped.at("strange_time"), 95u);
}

TEST(BadInput, AxisThatIsNotMeasuredIsNotUsed)
{
  const FlightPath path = FlightPath::loops(0.5);
  StateEstimator estimator({});
  for (Arrival a : simulate(path, {}, 10))
  {
    if (auto* fix = std::get_if<VelocityFix>(&a.measurement))
    {
      fix->sigma.z() = std::numeric_limits<double>::infinity();
      fix->v.z() = kNan;
    }
    feed(estimator, a.measurement);
  }
  EXPECT_GT(estimator.counters().velocity, 300u);
  EXPECT_LT(positionError(estimator, path), 1.5);
}

TEST(BadInput, ClockThatJumpsForGoodRestartsTheFilter)
{
  const FlightPath path = FlightPath::loops(0.5);
  StateEstimator estimator({});
  const auto shifted = [](Arrival a, double by)
  {
    std::visit([&](auto& m) { m.t += by; }, a.measurement);
    return a;
  };
  const auto flight = simulate(path, {}, 11);
  // The first object of the recording is three years off, as seen in the wild.
  estimator.add(PositionFix{-9.5e7, {0, 0, 0}, {1, 1, 1}, {0, 0, 0}, "gps"});
  for (const Arrival& a : flight) feed(estimator, a.measurement);
  ASSERT_TRUE(estimator.state());
  EXPECT_LT(positionError(estimator, path), 1.5);
  for (const Arrival& a : flight) feed(estimator, shifted(a, 5000.0).measurement);
  ASSERT_TRUE(estimator.state());
  EXPECT_LT((estimator.state()->p_W - path.position(20.0)).norm(), 1.5);
}

TEST(Crash, ShockDoesNotDestroyTheFilter)
{
  // Fast flight, stopped within 50 ms by the ground while the accelerometer clips and rings.
  FlightPath path = FlightPath::hover();
  path.position = [](double t) { return Eigen::Vector3d(t < 20.0 ? 8.0 * (t - 20.0) : 0.0, 0, 0); };
  for (std::uint64_t seed = 1; seed <= 5; ++seed)
  {
    SCOPED_TRACE(seed);
    core::Rng rng(seed);
    SensorSuite suite;
    suite.duration = 40.0;
    suite.imu_hz = 200.0;
    suite.yaw_hz = 5.0;
    suite.velocity_hz = 5.0;
    StateEstimator estimator({});
    for (Arrival a : simulate(path, suite, seed))
    {
      if (auto* imu = std::get_if<ImuSample>(&a.measurement))
        if (std::abs(imu->t - 20.0) < 0.05)
        {
          imu->f_B = 230.0 * rng.uniform3(-1.0, 1.0);
          imu->w_B = 30.0 * rng.uniform3(-1.0, 1.0);
        }
      feed(estimator, a.measurement);
      if (a.at > 26.0)
      {
        ASSERT_LT(estimator.state()->p_W.norm(), 1.5) << a.at;
        ASSERT_LT(estimator.state()->v_W.norm(), 1.0) << a.at;
      }
    }
  }
}

}  // namespace slalom::test
