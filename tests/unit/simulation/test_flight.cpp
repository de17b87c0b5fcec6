// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "TempFile.h"
#include "slalom/core/Math.h"
#include "slalom/core/Rng.h"
#include "slalom/simulation/FlightRecorder.h"
#include "slalom/simulation/ScriptedFlight.h"

namespace slalom::simulation
{
namespace
{
using core::Rng;
using Eigen::Vector3d;
using test::messageOf;
using test::TempFile;
using testing::HasSubstr;

std::vector<Waypoint> randomRoute(Rng& rng, bool with_yaw)
{
  std::vector<Waypoint> route;
  Vector3d p(0.0, 0.0, 2.0);
  for (int k = rng.integer(2, 6); k >= 0; --k)
  {
    Waypoint waypoint{p};
    if (with_yaw) waypoint.yaw = rng.uniform(-3.0, 3.0);
    route.push_back(waypoint);
    p += Vector3d(rng.uniform(-5.0, 8.0), rng.uniform(-5.0, 5.0), rng.uniform(-0.5, 0.5));
  }
  return route;
}

/// What a perfect IMU would dead-reckon: exponential attitude, trapezoidal velocity and position.
MotionSample deadReckoned(const Motion& motion, double duration, double dt)
{
  MotionSample state = motion.at(0.0);
  MotionSample before = state;
  const Vector3d gravity(0.0, 0.0, -kGravity);
  const auto force = [](const MotionSample& m) -> Vector3d
  { return m.q_WB.conjugate() * (m.a_W + Vector3d(0.0, 0.0, kGravity)); };
  for (double t = dt; t <= duration; t += dt)
  {
    const MotionSample now = motion.at(t);
    const Eigen::Quaterniond q =
        (state.q_WB * core::expSO3(0.5 * dt * (before.w_B + now.w_B))).normalized();
    const Vector3d a = 0.5 * (state.q_WB * force(before) + q * force(now)) + gravity;
    state.p_W += dt * state.v_W + 0.5 * dt * dt * a;
    state.v_W += dt * a;
    state.q_WB = q;
    before = now;
  }
  return state;
}

TEST(ScriptedFlight, SpecificForceIntegratesBackToTheTrajectory)
{
  for (std::uint64_t seed = 0; seed < 6; ++seed)
  {
    SCOPED_TRACE(seed);
    Rng rng(seed);
    const ScriptedFlight flight = ScriptedFlight::through(randomRoute(rng, seed % 2 == 1), {});
    const double duration = flight.duration() - 0.2;
    const MotionSample end = deadReckoned(flight, duration, 1e-3);
    const MotionSample truth = flight.at(duration);
    EXPECT_LT((end.p_W - truth.p_W).norm(), 0.02);
    EXPECT_LT((end.v_W - truth.v_W).norm(), 2e-3);
    EXPECT_LT(end.q_WB.angularDistance(truth.q_WB), 1e-3);
  }
}

TEST(ScriptedFlight, VelocityAndAccelerationAreDerivatives)
{
  Rng rng(3);
  const ScriptedFlight flight = ScriptedFlight::through(randomRoute(rng, false), {});
  constexpr double kStep = 1e-4;
  for (int k = 0; k < 300; ++k)
  {
    const double t = rng.uniform(0.0, flight.duration());
    const MotionSample before = flight.at(t - kStep), after = flight.at(t + kStep);
    const MotionSample now = flight.at(t);
    EXPECT_LT((now.v_W - (after.p_W - before.p_W) / (2.0 * kStep)).norm(), 1e-5);
    EXPECT_LT((now.a_W - (after.v_W - before.v_W) / (2.0 * kStep)).norm(), 2e-3);
  }
}

TEST(ScriptedFlight, KeepsItsLimitsAndStandsStillAtBothEnds)
{
  FlightConfig config;
  config.max_yaw_rate_radps = 0.6;
  for (std::uint64_t seed = 0; seed < 8; ++seed)
  {
    SCOPED_TRACE(seed);
    Rng rng(seed);
    const std::vector<Waypoint> route = randomRoute(rng, seed % 2 == 1);
    const ScriptedFlight flight = ScriptedFlight::through(route, config);
    double yaw = core::yawOf(flight.at(0.0).q_WB);
    constexpr double kStep = 0.01;
    for (double t = 0.0; t < flight.duration(); t += kStep)
    {
      const MotionSample m = flight.at(t);
      ASSERT_LE(m.v_W.cwiseAbs().maxCoeff(), config.speed_mps + 1e-9);
      ASSERT_LE(m.a_W.cwiseAbs().maxCoeff(), config.acceleration_mps2 + 1e-9);
      const double now = core::yawOf(m.q_WB);
      ASSERT_LE(std::abs(core::wrapAngle(now - yaw)), config.max_yaw_rate_radps * kStep + 1e-9);
      yaw = now;
      ASSERT_TRUE(t > config.hover_before_s || m.p_W.isApprox(route.front().p_W, 1e-9));
    }
    const MotionSample end = flight.at(flight.duration());
    EXPECT_LT((end.p_W - route.back().p_W).norm(), 1e-9);
    EXPECT_EQ(flight.at(flight.duration() - config.hover_after_s + 0.01).v_W.norm(), 0.0);
  }
}

TEST(ScriptedFlight, TiltFollowsTheThrustAndTheHeadingIsExact)
{
  for (std::uint64_t seed = 0; seed < 200; ++seed)
  {
    Rng rng(seed);
    const Vector3d a = rng.uniform3(-4.0, 4.0);
    const double yaw = rng.uniform(-3.1, 3.1);
    const Eigen::Quaterniond q = hoverAttitude(a, yaw);
    const Vector3d thrust = q.conjugate() * (a + Vector3d(0.0, 0.0, kGravity));
    EXPECT_LT(thrust.head<2>().norm(), 1e-9);
    EXPECT_GT(thrust.z(), 0.0);
    EXPECT_NEAR(core::wrapAngle(core::yawOf(q) - yaw), 0.0, 1e-9);
  }
}

TEST(ScriptedFlight, HeadsAlongThePath)
{
  const ScriptedFlight flight =
      ScriptedFlight::through({{{0, 0, 2}}, {{0, 20, 2}}, {{-20, 20, 2}}}, {});
  EXPECT_NEAR(core::yawOf(flight.at(0.0).q_WB), 0.5 * M_PI, 1e-6);
  EXPECT_NEAR(core::yawOf(flight.at(flight.duration()).q_WB), -M_PI, 0.02);
}

std::string tumOf(const ScriptedFlight& flight, double step)
{
  std::string text;
  char line[256];
  for (double t = 0.0; t <= flight.duration(); t += step)
  {
    const MotionSample m = flight.at(t);
    std::snprintf(line, sizeof(line), "%.6f %.6f %.6f %.6f %.8f %.8f %.8f %.8f\n", 100.0 + t,
                  m.p_W.x(), m.p_W.y(), m.p_W.z(), m.q_WB.x(), m.q_WB.y(), m.q_WB.z(), m.q_WB.w());
    text += line;
  }
  return text;
}

TEST(ScriptedFlight, TumFileIsFlownAsRecorded)
{
  FlightConfig config;
  config.hover_after_s = 0.5;
  for (const double step : {0.005, 0.02, 0.1})
  {
    SCOPED_TRACE(step);
    Rng rng(7);
    const ScriptedFlight original = ScriptedFlight::through(randomRoute(rng, false), config);
    const TempFile file("t.tum", tumOf(original, step));
    const ScriptedFlight replayed = ScriptedFlight::load(file.path(), config);
    // It begins and ends at rest, so the standstills are added to those recorded.
    EXPECT_NEAR(replayed.duration(), original.duration() + 2.5, 0.11);
    for (double t = 0.0; t < original.duration() - 0.1; t += 0.037)
    {
      const MotionSample a = original.at(t), b = replayed.at(t + config.hover_before_s);
      ASSERT_LT((a.p_W - b.p_W).norm(), 2e-3) << t;
      ASSERT_LT((a.v_W - b.v_W).norm(), 0.03) << t;
      ASSERT_LT(a.q_WB.angularDistance(b.q_WB), 0.06) << t;
    }
    const MotionSample end = deadReckoned(replayed, 20.0, 1e-3);
    EXPECT_LT((end.p_W - replayed.at(20.0).p_W).norm(), 0.05);
  }
}

TEST(FlightFiles, MalformedScriptsNameFileLineAndValue)
{
  const std::pair<const char*, std::vector<const char*>> cases[] = {
      {"1,2,3\n1,2,x\n", {"s.csv:2", "'x'"}},
      {"1,2,3\n1,2\n", {"s.csv:2", "2 fields"}},
      {"a,b,1,2,3,4,5,6\na,b,1,2,3,4,5,6\n", {"s.csv:2", "second path"}},
      {"a,b,1,2,3,4,5\n1,2,3\n", {"s.csv:1"}},
      {"1,2,3\n", {"s.csv", "two"}},
      {"1,2,3\n1,2,3\n", {"s.csv"}},
      {"1,2,3,0.1\n4,5,6\n", {"s.csv", "yaw"}},
      {"0 1 2 3 0 0 0 1\n0 1 2 3 0 0 0 1\n", {"s.csv:2", "time 0"}},
      {"0 1 2 3 0 0 0 2\n", {"s.csv:1", "norm"}},
      {"0 1 2 3 0 0 0\n", {"s.csv:1", "7 fields"}},
      {"", {"s.csv:1"}},
  };
  for (const auto& [text, parts] : cases)
  {
    SCOPED_TRACE(text);
    const TempFile file("s.csv", *text ? text : "\n");
    const std::string message =
        messageOf([&] { (void)ScriptedFlight::load(file.path(), FlightConfig{}); });
    for (const char* part : parts) EXPECT_THAT(message, HasSubstr(part));
  }
}

TEST(FirstContact, SaysWhereThePathTouchesTheWorld)
{
  const World world = World::of({{{5.0, 0.3}, 0.2, 5.0}}, {}, true);
  const ScriptedFlight flight = ScriptedFlight::through({{{0, 0, 2}}, {{10, 0, 2}}}, {});
  EXPECT_FALSE(firstContact(world, flight, flight.duration(), 0.09));
  const auto contact = firstContact(world, flight, flight.duration(), 0.35);
  ASSERT_TRUE(contact);
  EXPECT_NEAR(contact->distance, 0.35, 0.02);
  EXPECT_LT(contact->p_W.x(), 5.0);
  EXPECT_GT(contact->p_W.x(), 4.0);
  const ScriptedFlight low = ScriptedFlight::through({{{0, 0, 1}}, {{0, 3, -1}}}, {});
  EXPECT_TRUE(firstContact(world, low, low.duration(), 0.1));
}
}  // namespace
}  // namespace slalom::simulation
