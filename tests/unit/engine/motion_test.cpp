// SPDX-License-Identifier: BSD-3-Clause
// Prediction to the time of effect, and the news of a cycle.
#include <gtest/gtest.h>

#include "FlightEvents.h"
#include "MotionPredictor.h"
#include "slalom/core/Rng.h"

namespace slalom::engine
{
namespace
{
core::Vehicle vehicle(double lag, double yaw_lag, double delay)
{
  core::Vehicle v;
  v.velocity_lag_s = lag;
  v.yaw_rate_lag_s = yaw_lag;
  v.command_delay_s = delay;
  return v;
}

/// A vehicle by small steps: what the closed form must agree with.
struct BruteForce
{
  core::Vehicle limits;
  Eigen::Vector3d push = Eigen::Vector3d::Zero();
  std::vector<std::pair<double, core::VelocityCommand>> sent{};
  core::VehicleState state{};

  void run(double until)
  {
    constexpr double kStep = 2e-5;
    double yaw = state.yaw(), rate = state.w_B.z();
    for (; state.t < until; state.t += kStep)
    {
      core::VelocityCommand u;
      for (const auto& [t, command] : sent)
        if (t + limits.command_delay_s <= state.t + 1e-9) u = command;
      state.v_W += kStep * ((u.v_W - state.v_W) / limits.velocity_lag_s + push);
      state.p_L += kStep * state.v_W;
      rate += kStep * (u.yaw_rate - rate) / limits.yaw_rate_lag_s;
      yaw += kStep * rate;
    }
    state.p_W = state.p_L;
    state.q_WB = core::fromYaw(yaw);
    state.w_B = {0.0, 0.0, rate};
  }
};

core::VelocityCommand anyCommand(core::Rng& rng)
{
  return {rng.normal3(0.7), rng.uniform(-1.0, 1.0)};
}

TEST(MotionPredictor, AgreesWithBruteForceAcrossChangesOfCommand)
{
  for (std::uint64_t seed = 1; seed <= 10; ++seed)
  {
    SCOPED_TRACE(seed);
    core::Rng rng(seed);
    const core::Vehicle limits =
        vehicle(rng.uniform(0.1, 0.5), rng.uniform(0.1, 0.3), rng.uniform(0.0, 0.25));
    MotionPredictor predictor(limits);
    BruteForce truth{limits};
    for (int k = 0; k < 10; ++k)
    {
      truth.sent.emplace_back(0.05 * k, anyCommand(rng));
      predictor.sent(truth.sent.back().first, truth.sent.back().second);
    }
    truth.run(0.3 + rng.uniform(0.0, 0.1));
    const core::VehicleState now = truth.state;
    const double effect = predictor.effectOf(0.5);
    truth.run(effect);
    const core::VehicleState predicted = predictor.at(now, effect);
    EXPECT_EQ(predicted.t, effect);
    EXPECT_LT((predicted.p_L - truth.state.p_L).norm(), 1e-3);
    EXPECT_LT((predicted.p_W - truth.state.p_W).norm(), 1e-3);
    EXPECT_LT((predicted.v_W - truth.state.v_W).norm(), 2e-3);
    EXPECT_LT(std::abs(core::wrapAngle(predicted.yaw() - truth.state.yaw())), 1e-3);
    EXPECT_NEAR(predicted.w_B.z(), truth.state.w_B.z(), 2e-3);
  }
}

TEST(MotionPredictor, LeavesAFreshStateAlone)
{
  core::Rng rng(1);
  MotionPredictor predictor(vehicle(0.2, 0.0, 0.0));
  for (int k = 0; k < 20; ++k)
  {
    core::VehicleState state;
    state.t = 0.05 * k;
    state.p_L = rng.normal3(3.0);
    state.v_W = rng.normal3(1.0);
    state.w_B = rng.normal3(0.2);
    state.q_WB = core::expSO3(rng.normal3(0.3));
    predictor.observe(state);
    const core::VehicleState same = predictor.at(state, predictor.effectOf(state.t));
    EXPECT_EQ(same.p_L, state.p_L);
    EXPECT_EQ(same.v_W, state.v_W);
    EXPECT_EQ(same.w_B, state.w_B);
    EXPECT_EQ(same.q_WB.coeffs(), state.q_WB.coeffs());
    predictor.sent(state.t, anyCommand(rng));
  }
}

TEST(MotionPredictor, KnowsWhichCommandIsObeyed)
{
  MotionPredictor predictor(vehicle(0.2, 0.0, 0.1));
  predictor.sent(1.0, {{1.0, 0.0, 0.0}, 0.0});
  predictor.sent(1.05, {{2.0, 0.0, 0.0}, 0.0});
  EXPECT_EQ(predictor.inEffect(1.09).v_W.x(), 0.0);
  EXPECT_EQ(predictor.inEffect(1.12).v_W.x(), 1.0);
  EXPECT_EQ(predictor.inEffect(3.0).v_W.x(), 2.0);
}

TEST(MotionPredictor, KeepsTheVelocityWhileNoCommandIsKnown)
{
  MotionPredictor predictor(vehicle(0.2, 0.0, 0.1));
  core::VehicleState state;
  state.v_W = {1.0, -0.5, 0.2};
  EXPECT_LT((predictor.at(state, 0.1).p_L - 0.1 * state.v_W).norm(), 1e-12);
  EXPECT_EQ(predictor.inEffect(1.0).v_W.norm(), 0.0);
  predictor.sent(0.05, {});
  EXPECT_LT((predictor.at(state, 0.15).v_W - state.v_W).norm(), 1e-12) << "not in effect yet";
  EXPECT_LT(predictor.at(state, 2.0).v_W.norm(), 1e-3);
  predictor.forget();
  EXPECT_LT((predictor.at(state, 2.0).v_W - state.v_W).norm(), 1e-12);
}

/// Flies random commands under a push; what the observer makes of it after `seconds`.
Eigen::Vector3d observed(const Eigen::Vector3d& push, double noise_mps, double seconds,
                         std::uint64_t seed)
{
  core::Rng rng(seed);
  const core::Vehicle limits = vehicle(0.25, 0.1, 0.1);
  MotionPredictor predictor(limits);
  BruteForce truth{limits, push};
  for (int k = 0; 0.05 * k < seconds; ++k)
  {
    truth.run(0.05 * k);
    core::VehicleState estimate = truth.state;
    estimate.v_W += rng.normal3(noise_mps);
    predictor.observe(estimate);
    if (k % 8 == 0) truth.sent.emplace_back(truth.state.t, anyCommand(rng));
    predictor.sent(truth.state.t, truth.sent.back().second);
  }
  return predictor.disturbance();
}

TEST(MotionPredictor, FindsASteadyPushWhateverIsCommanded)
{
  for (std::uint64_t seed = 1; seed <= 4; ++seed)
  {
    SCOPED_TRACE(seed);
    core::Rng rng(100 + seed);
    const Eigen::Vector3d push = rng.normal3(0.5);
    EXPECT_LT((observed(push, 0.0, 15.0, seed) - push).norm(), 0.02 + 0.01 * push.norm());
    EXPECT_LT((observed(push, 0.03, 15.0, seed) - push).norm(), 0.35);
    EXPECT_LT(observed(Eigen::Vector3d::Zero(), 0.0, 15.0, seed).norm(), 0.02);
  }
}

TEST(MotionPredictor, BoundsWhatItBelieves)
{
  EXPECT_LE(observed({30.0, 0.0, 0.0}, 0.0, 5.0, 1).norm(), 2.0 + 1e-12);
  MotionPredictor predictor(vehicle(0.2, 0.0, 0.0));
  core::VehicleState state;
  predictor.sent(-0.1, {});
  predictor.observe(state);
  state.t = 0.05;
  state.v_W.x() = std::nan("");
  predictor.observe(state);
  EXPECT_EQ(predictor.disturbance().norm(), 0.0);
  EXPECT_TRUE(std::isnan(predictor.at(state, 1.0).v_W.x())) << "never hides that it is broken";
}

class News : public testing::Test
{
 protected:
  /// Names of the events of one cycle.
  std::string step(EngineStatus status, const std::string& unsafe = {}, bool waiting = false,
                   bool driven = true)
  {
    std::string names;
    for (const core::Event& event :
         events.update({t_ += 0.05, status, driven, unsafe, waiting, "why"}))
      names += (names.empty() ? "" : " ") + event.name;
    return names;
  }
  FlightEvents events;

 private:
  double t_ = 0.0;
};
constexpr auto kFly = EngineStatus::Navigating;

TEST_F(News, TellsEveryChangeOfStatusOnce)
{
  EXPECT_EQ(step(EngineStatus::WaitingForState, "", false, false), "WAITING_FOR_STATE");
  EXPECT_EQ(step(EngineStatus::WaitingForState, "", false, false), "");
  EXPECT_EQ(step(EngineStatus::NoMission, "", false, false), "");
  EXPECT_EQ(step(kFly), "NAVIGATING");
  EXPECT_EQ(step(kFly), "");
  EXPECT_EQ(step(EngineStatus::GoalBlocked), "GOAL_BLOCKED");
  EXPECT_EQ(step(EngineStatus::Unreachable), "UNREACHABLE");
  EXPECT_EQ(step(EngineStatus::GoalReached), "GOAL_REACHED");
}

TEST_F(News, AFaultThatComesAndGoesIsOneStop)
{
  step(kFly);
  EXPECT_EQ(step(kFly, "map too old"), "SAFE_STOP");
  for (int k = 0; k < 100; ++k) EXPECT_EQ(step(kFly, k % 9 == 0 ? "map too old" : ""), "");
  for (int k = 0; k < 20; ++k) step(kFly);
  EXPECT_EQ(events.safeStops(), 1u);
  EXPECT_EQ(events.recoveries(), 1u);
  EXPECT_EQ(step(kFly, "map too old"), "SAFE_STOP");
}

TEST_F(News, WaitingIsAStopOnlyWhenItLasts)
{
  step(kFly);
  for (int k = 0; k < 20; ++k) EXPECT_EQ(step(kFly, "", true), "") << k;
  std::string told;
  for (int k = 0; k < 20; ++k) told += step(kFly, "", true);
  EXPECT_EQ(told, "SAFE_STOP");
}

TEST_F(News, NobodyIsToldOfARecoveryThatDoesNotFly)
{
  step(kFly);
  step(kFly, "state too old");
  for (int k = 0; k < 30; ++k) EXPECT_EQ(step(kFly, "", false, false), "") << "suspended";
  EXPECT_EQ(step(EngineStatus::GoalReached), "GOAL_REACHED");
  for (int k = 0; k < 30; ++k) EXPECT_NE(step(kFly), "RECOVER") << "the stop was over";
}

}  // namespace
}  // namespace slalom::engine
