// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "SimulatedFlight.h"

namespace slalom::test
{
namespace
{
using core::PositionFix;
using core::VehicleState;
using estimation::FilterConfig;
using estimation::StateEstimator;

template <class T>
bool is(const Arrival& a)
{
  return std::holds_alternative<T>(a.measurement);
}
}  // namespace

// Whatever the order of arrival, the world state is that of the right order (once the heading has
// been decided; the decision itself is taken with what has arrived).
TEST(Delay, LateEqualsInOrder)
{
  for (std::uint64_t seed = 1; seed <= 6; ++seed)
  {
    SCOPED_TRACE(seed);
    core::Rng rng(seed);
    SensorSuite suite;
    suite.duration = 12.0;
    suite.velocity_in_body = seed % 2 == 0;
    auto in_order = simulate(FlightPath::loops(0.5), suite, seed);
    auto late = in_order;
    for (Arrival& a : late)
      if (!is<core::ImuSample>(a) && a.at > 3.0 && a.at < 11.5) a.at += rng.uniform(0.0, 0.4);
    std::stable_sort(late.begin(), late.end(),
                     [](const Arrival& a, const Arrival& b) { return a.at < b.at; });
    // An outlier and a wild run of them: gates and re-initialisation must replay too.
    const auto spoil = [](Arrival& a)
    {
      if (auto* fix = std::get_if<PositionFix>(&a.measurement))
        if (fix->t > 5.0) fix->p_W.x() += 4.0;
    };
    std::for_each(in_order.begin(), in_order.end(), spoil);
    std::for_each(late.begin(), late.end(), spoil);

    StateEstimator a({});
    StateEstimator b({});
    for (const Arrival& arrival : in_order) feed(a, arrival.measurement);
    for (const Arrival& arrival : late) feed(b, arrival.measurement);
    ASSERT_TRUE(a.state() && b.state());
    EXPECT_EQ(a.state()->t, b.state()->t);
    EXPECT_LT((a.state()->p_W - b.state()->p_W).norm(), 1e-9);
    EXPECT_LT((a.state()->v_W - b.state()->v_W).norm(), 1e-9);
    EXPECT_LT(a.state()->q_WB.angularDistance(b.state()->q_WB), 1e-7);
    EXPECT_LT((a.state()->covariance - b.state()->covariance).cwiseAbs().maxCoeff(), 1e-9);
    EXPECT_EQ(a.counters().resets, b.counters().resets);
    EXPECT_GT(a.counters().resets, 0u);
    EXPECT_EQ(a.counters().dropped, b.counters().dropped);
  }
}

TEST(Delay, GpsLatencyIsCompensated)
{
  // A fast path, so that latency is what there is to see; noise wide enough for both to be heard.
  SensorSuite suite;
  suite.duration = 30.0;
  suite.gps_delay = 0.2;
  suite.velocity_hz = 0.0;
  suite.gps_sigma.setConstant(0.3);
  const FlightPath path = FlightPath::loops(0.5, 1.5);
  double compensated = 0.0;
  double naive = 0.0;
  for (std::uint64_t seed = 1; seed <= 5; ++seed)
  {
    StateEstimator told({});
    StateEstimator untold({});
    for (const Arrival& a : simulate(path, suite, seed))
    {
      feed(told, a.measurement);
      Arrival wrong = a;
      // What a filter without a time line does: the fix counts when it arrives.
      if (auto* fix = std::get_if<PositionFix>(&wrong.measurement)) fix->t = a.at;
      feed(untold, wrong.measurement);
      if (a.at < 15.0 || !told.state() || !untold.state()) continue;
      compensated += (told.state()->p_W - path.position(told.state()->t)).squaredNorm();
      naive += (untold.state()->p_W - path.position(untold.state()->t)).squaredNorm();
    }
  }
  EXPECT_LT(std::sqrt(compensated), 0.25 * std::sqrt(naive));
  RecordProperty("compensated_over_uncompensated", std::to_string(std::sqrt(compensated / naive)));
}

TEST(Delay, TooOldIsDroppedAndCounted)
{
  FilterConfig config;
  config.max_delay_s = 0.3;
  SensorSuite suite;
  suite.gps_delay = 0.4;
  StateEstimator estimator(config);
  for (const Arrival& a : simulate(FlightPath::loops(0.5), suite, 3))
    if (a.at < suite.duration) feed(estimator, a.measurement);
  EXPECT_EQ(estimator.counters().position, 0u);
  EXPECT_GE(estimator.counters().dropped.at("too_old"), 95u);
}

TEST(StateAt, InterpolatesTheRecentPastAndBoundsTheFuture)
{
  const FilterConfig config;
  SensorSuite suite;
  suite.imu_noise_scale = 1e-3;
  suite.bias_scale = 0.0;
  suite.gps_sigma.setConstant(1e-3);
  suite.velocity_sigma = 1e-3;
  const FlightPath path = FlightPath::loops(0.5);
  StateEstimator estimator(config);
  EXPECT_FALSE(estimator.stateAt(1.0));
  for (const Arrival& a : simulate(path, suite, 4)) feed(estimator, a.measurement);
  const VehicleState now = *estimator.state();
  for (double back = 0.0; back <= 0.9; back += 0.0137)
  {
    const auto s = estimator.stateAt(now.t - back);
    ASSERT_TRUE(s) << back;
    EXPECT_EQ(s->t, now.t - back);
    EXPECT_LT((s->p_W - path.position(s->t)).norm(), 0.02);
    EXPECT_LT((s->v_W - path.velocity(s->t)).norm(), 0.02);
    EXPECT_LT(s->q_WB.angularDistance(path.attitude(s->t)), 0.02);
    const Eigen::Vector3d moved = path.position(now.t) - path.position(s->t);
    EXPECT_LT((now.p_L - s->p_L - moved).norm(), 0.02) << "local path " << back;
  }
  const auto ahead = estimator.stateAt(now.t + 0.2);
  ASSERT_TRUE(ahead);
  EXPECT_LT((ahead->p_W - (now.p_W + 0.2 * now.v_W)).norm(), 1e-9);
  EXPECT_LT((ahead->p_L - (now.p_L + 0.2 * now.v_W)).norm(), 1e-9);
  EXPECT_GT(ahead->covariance(0, 0), now.covariance(0, 0));
  EXPECT_TRUE(estimator.stateAt(now.t + 0.99 * config.max_extrapolation_s));
  EXPECT_FALSE(estimator.stateAt(now.t + 1.01 * config.max_extrapolation_s));
  EXPECT_FALSE(estimator.stateAt(now.t - 60.0));
  EXPECT_FALSE(estimator.stateAt(std::nan("")));
}

}  // namespace slalom::test
