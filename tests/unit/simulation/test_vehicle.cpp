// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <stdexcept>

#include "slalom/core/Rng.h"
#include "slalom/simulation/SimulatedVehicle.h"

namespace slalom::simulation
{
namespace
{
using core::VelocityCommand;
using Eigen::Vector3d;

VelocityCommand anyCommand(core::Rng& rng, double speed)
{
  return {rng.uniform3(-speed, speed), rng.uniform(-1.0, 1.0)};
}

/// Limits out of the way, no delay.
AirframeConfig lagsOnly(core::Rng& rng)
{
  AirframeConfig config;
  config.velocity_lag_s = rng.uniform(0.05, 0.5);
  config.yaw_rate_lag_s = rng.uniform(0.0, 0.5);
  config.command_delay_s = 0.0;
  config.max_acceleration_mps2 = 1e6;
  config.max_yaw_rate_radps = 1e6;
  return config;
}

core::Vehicle modelOf(const AirframeConfig& config)
{
  core::Vehicle model;
  model.velocity_lag_s = config.velocity_lag_s;
  model.yaw_rate_lag_s = config.yaw_rate_lag_s;
  return model;
}

void expectEqual(const core::Motion& a, const core::Motion& b, double tolerance)
{
  EXPECT_LE((a.p - b.p).norm(), tolerance);
  EXPECT_LE((a.v - b.v).norm(), tolerance);
  EXPECT_NEAR(a.yaw, b.yaw, tolerance);
  EXPECT_NEAR(a.yaw_rate, b.yaw_rate, tolerance);
}

TEST(SimulatedVehicle, FollowsTheLagLawExactly)
{
  for (std::uint64_t seed = 1; seed <= 50; ++seed)
  {
    SCOPED_TRACE(seed);
    core::Rng rng(seed);
    const AirframeConfig config = lagsOnly(rng);
    SimulatedVehicle vehicle(config, rng.uniform3(-5.0, 5.0), 0.4);
    core::Motion expected = vehicle.motion();
    for (int k = 0; k < 40; ++k)
    {
      const VelocityCommand command = anyCommand(rng, 2.0);
      const double dt = rng.uniform(1e-3, 0.3);
      vehicle.command(command);
      for (int part = 0; part < 7; ++part) vehicle.advance(dt / 7.0);
      expected = core::held(expected, command, dt, modelOf(config));
      expectEqual(vehicle.motion(), expected, 1e-10);
    }
  }
}

TEST(SimulatedVehicle, ObeysAfterItsDelay)
{
  core::Rng rng(3);
  AirframeConfig config = lagsOnly(rng);
  config.command_delay_s = 0.07;
  SimulatedVehicle vehicle(config, Vector3d::Zero(), 0.0);
  const VelocityCommand first{{1.0, -0.5, 0.2}, 0.3}, second{{-1.0, 0.0, 0.0}, -0.2};
  vehicle.command(first);
  vehicle.advance(0.05);
  EXPECT_EQ(vehicle.motion().v, Vector3d::Zero());
  vehicle.command(second);  // both are on their way now
  vehicle.advance(0.1);
  core::Motion expected = core::held({}, first, 0.05, modelOf(config));
  expected = core::held(expected, second, 0.03, modelOf(config));
  expectEqual(vehicle.motion(), expected, 1e-12);
}

TEST(SimulatedVehicle, NeverExceedsItsLimitsAndReachesThem)
{
  for (std::uint64_t seed = 1; seed <= 20; ++seed)
  {
    SCOPED_TRACE(seed);
    core::Rng rng(seed);
    AirframeConfig config = lagsOnly(rng);
    config.max_acceleration_mps2 = rng.uniform(1.0, 6.0);
    config.max_yaw_rate_radps = 0.5;
    SimulatedVehicle vehicle(config, Vector3d::Zero(), 0.0);
    double largest = 0.0, fastest_turn = 0.0;
    for (int k = 0; k < 2000; ++k)
    {
      if (k % 100 == 0) vehicle.command(anyCommand(rng, 5.0));
      const Vector3d before = vehicle.motion().v;
      vehicle.advance(5e-3);
      largest = std::max(largest, (vehicle.motion().v - before).norm() / 5e-3);
      EXPECT_LE(vehicle.sample().a_W.norm(), config.max_acceleration_mps2 * (1.0 + 1e-9));
      fastest_turn = std::max(fastest_turn, std::abs(vehicle.motion().yaw_rate));
    }
    EXPECT_NEAR(largest, config.max_acceleration_mps2, 1e-6);
    EXPECT_LE(fastest_turn, 0.5 + 1e-12);
    EXPECT_GT(fastest_turn, 0.4);
  }
}

/// The law itself, integrated with small steps.
core::Motion integrated(const AirframeConfig& config, const VelocityCommand& command, double time)
{
  constexpr double kStep = 1e-5;
  core::Motion m;
  for (double t = 0.0; t < time - 0.5 * kStep; t += kStep)
  {
    const auto acceleration = [&](const Vector3d& v)
    {
      const Vector3d a =
          (command.v_W - v) / config.velocity_lag_s + config.drag_per_s * config.wind_mps;
      return Vector3d(a * std::min(1.0, config.max_acceleration_mps2 / a.norm()));
    };
    const Vector3d middle = m.v + 0.5 * kStep * acceleration(m.v);
    m.v += kStep * acceleration(middle);
    m.p += kStep * middle;
  }
  return m;
}

TEST(SimulatedVehicle, SolvesItsLawAtTheLimitAndInWind)
{
  for (std::uint64_t seed = 1; seed <= 8; ++seed)
  {
    SCOPED_TRACE(seed);
    core::Rng rng(seed);
    AirframeConfig config = lagsOnly(rng);
    config.max_acceleration_mps2 = 3.0;
    config.wind_mps = rng.uniform3(-5.0, 5.0);
    const VelocityCommand command{rng.uniform3(-4.0, 4.0), 0.0};
    SimulatedVehicle whole(config, Vector3d::Zero(), 0.0), parts(config, Vector3d::Zero(), 0.0);
    whole.command(command);
    parts.command(command);
    whole.advance(0.8);
    for (int k = 0; k < 160; ++k) parts.advance(5e-3);
    expectEqual(parts.motion(), whole.motion(), 1e-10);
    const core::Motion law = integrated(config, command, 0.8);
    EXPECT_LT((whole.motion().v - law.v).norm(), 1e-4);
    EXPECT_LT((whole.motion().p - law.p).norm(), 1e-4);
  }
}

TEST(SimulatedVehicle, TurnsAsItsGyroscopeSaysAndAcceleratesAsItsAccelerometerSays)
{
  core::Rng rng(11);
  AirframeConfig config;
  config.wind_mps = {2.0, -1.0, 0.0};
  SimulatedVehicle vehicle(config, Vector3d(0.0, 0.0, 1.5), 0.7);
  Eigen::Quaterniond turned = vehicle.sample().q_WB;
  Vector3d velocity = Vector3d::Zero();
  for (int k = 0; k < 2000; ++k)
  {
    // Slewed, as an output gate would.
    if (k % 10 == 0)
      vehicle.command(
          {{std::sin(0.01 * k), std::cos(0.007 * k) - 1.0, 0.0}, 0.5 * std::sin(0.01 * k)});
    vehicle.advance(5e-3);
    const MotionSample& m = vehicle.sample();
    const double angle = m.w_B.norm() * 5e-3;
    turned = turned * Eigen::Quaterniond(Eigen::AngleAxisd(angle, m.w_B.stableNormalized()));
    velocity += 5e-3 * m.a_W;
    ASSERT_LT(turned.angularDistance(m.q_WB), 1e-6);
    ASSERT_LT((velocity - m.v_W).norm(), 1e-9);
    ASSERT_LT(m.w_B.norm(), 3.0);
  }
}

TEST(SimulatedVehicle, RefusesWhatIsNotFinite)
{
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(SimulatedVehicle({}, Vector3d(nan, 0.0, 0.0), 0.0), std::invalid_argument);
  SimulatedVehicle vehicle({}, Vector3d::Zero(), 0.0);
  EXPECT_THROW(vehicle.command({{0.0, nan, 0.0}, 0.0}), std::invalid_argument);
  EXPECT_THROW(vehicle.command({Vector3d::Zero(), nan}), std::invalid_argument);
}
}  // namespace
}  // namespace slalom::simulation
