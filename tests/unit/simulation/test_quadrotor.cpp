// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

#include "slalom/core/Rng.h"
#include "slalom/simulation/Quadrotor.h"

namespace slalom::simulation
{
namespace
{
using core::VelocityCommand;
using Eigen::Vector3d;

constexpr double kStep = Quadrotor::kStep;
constexpr double kPi = std::numbers::pi;

AirframeConfig quadrotor()
{
  AirframeConfig config;
  config.model = AirframeModel::Quadrotor;
  return config;
}

VelocityCommand anyCommand(core::Rng& rng, double speed)
{
  return {rng.uniform3(-speed, speed), rng.uniform(-3.0, 3.0)};
}

double tiltOf(const MotionSample& m)
{
  return std::acos(std::min(1.0, (m.q_WB * Vector3d::UnitZ()).z()));
}

double headingOf(const MotionSample& m)
{
  const Vector3d x = m.q_WB * Vector3d::UnitX();
  return std::atan2(x.y(), x.x());
}

TEST(Quadrotor, AnswersAStepWithTheLagThatIsAskedFor)
{
  for (std::uint64_t seed = 1; seed <= 20; ++seed)
  {
    SCOPED_TRACE(seed);
    core::Rng rng(seed);
    AirframeConfig config = quadrotor();
    config.drag_per_s = config.velocity_integral = 0.0;
    config.velocity_lag_s = rng.uniform(0.2, 0.4);
    config.command_delay_s = rng.uniform(0.0, 0.1);
    config.attitude_lag_s = rng.uniform(0.04, 0.1);
    Quadrotor vehicle(config, Vector3d::Zero(), rng.uniform(-3.0, 3.0), seed);
    const Vector3d wanted = 0.1 * rng.direction();  // small enough to be linear
    vehicle.command({wanted, 0.0});
    double peak = 0.0, area = 0.0, at_lag = 0.0;
    for (int k = 1; k <= 4000; ++k)
    {
      vehicle.advance(kStep);
      const double reached = vehicle.sample().v_W.dot(wanted) / wanted.squaredNorm();
      peak = std::max(peak, reached);
      area += kStep * (1.0 - reached);
      if (std::abs(k * kStep - config.velocity_lag_s - config.command_delay_s) < 0.6 * kStep)
        at_lag = reached;
    }
    EXPECT_NEAR(area, config.velocity_lag_s + config.command_delay_s, 2e-3);
    EXPECT_LT(peak, 1.06);
    EXPECT_NEAR(at_lag, 0.63, 0.12) << "as a first order would";
    EXPECT_LT((vehicle.sample().v_W - wanted).norm(), 1e-4);
  }
}

TEST(Quadrotor, DoesNotDependOnHowTimeIsDivided)
{
  AirframeConfig config = quadrotor();
  config.gust_mps = 1.0;
  config.wind_mps = {2.0, 1.0, 0.0};
  core::Rng rng(5);
  Quadrotor fine(config, Vector3d::Zero(), 0.3, 9), coarse(config, Vector3d::Zero(), 0.3, 9);
  for (int k = 0; k < 40; ++k)
  {
    const VelocityCommand command = anyCommand(rng, 2.0);
    fine.command(command);
    coarse.command(command);
    for (int part = 0; part < 160; ++part) fine.advance(0.25 * kStep);
    coarse.advance(40 * kStep);
    ASSERT_EQ(fine.sample().p_W, coarse.sample().p_W) << k;
    ASSERT_EQ(fine.sample().v_W, coarse.sample().v_W) << k;
    ASSERT_NEAR(fine.time(), coarse.time(), 1e-12);
  }
}

TEST(Quadrotor, NeverExceedsItsLimits)
{
  double largest_tilt = 0.0, largest_thrust = 0.0, fastest_turn = 0.0, largest = 0.0;
  for (std::uint64_t seed = 1; seed <= 10; ++seed)
  {
    SCOPED_TRACE(seed);
    core::Rng rng(seed);
    AirframeConfig config = quadrotor();
    config.max_acceleration_mps2 = 12.0;
    config.max_tilt_deg = 30.0;
    config.max_thrust_g = 1.6;
    config.max_yaw_rate_radps = 0.7;
    config.gust_mps = 1.0;
    const double tilt_limit = config.max_tilt_deg * std::numbers::pi / 180.0;
    Quadrotor vehicle(config, Vector3d::Zero(), 0.0, seed);
    double heading = 0.0;
    for (int k = 0; k < 10000; ++k)
    {
      if (k % 500 == 0)
      {
        // On the mean: while it tilts, the projection of its x axis swings a little.
        const double turned = std::remainder(headingOf(vehicle.sample()) - heading, 2.0 * kPi);
        fastest_turn = std::max(fastest_turn, std::abs(turned) / 0.5);
        EXPECT_LE(std::abs(turned), 0.5 * config.max_yaw_rate_radps + 0.1);
        heading += turned;
        vehicle.command(anyCommand(rng, 6.0));
      }
      vehicle.advance(kStep);
      const MotionSample& m = vehicle.sample();
      ASSERT_LE(tiltOf(m), tilt_limit + 0.02);
      ASSERT_LE(vehicle.thrust(), config.max_thrust_g * kGravity + 1e-9);
      ASSERT_GE(vehicle.thrust(), config.min_thrust_g * kGravity - 1e-9);
      ASSERT_LE(m.w_B.head<2>().norm(), config.max_body_rate_radps * std::sqrt(2.0) + 1e-9);
      largest_tilt = std::max(largest_tilt, tiltOf(m));
      largest_thrust = std::max(largest_thrust, vehicle.thrust());
      largest = std::max(largest, m.a_W.norm());
    }
  }
  EXPECT_GT(largest_tilt, 0.95 * 30.0 * std::numbers::pi / 180.0) << "the limits bind";
  EXPECT_GT(largest_thrust, 1.5 * kGravity);
  EXPECT_GT(fastest_turn, 0.6);
  EXPECT_GT(largest, 6.0);
}

TEST(Quadrotor, KeepsItsAccelerationSetpointWithinTheLimit)
{
  for (std::uint64_t seed = 1; seed <= 10; ++seed)
  {
    SCOPED_TRACE(seed);
    core::Rng rng(seed);
    AirframeConfig config = quadrotor();
    config.drag_per_s = 0.0;
    config.max_acceleration_mps2 = 3.0;
    Quadrotor vehicle(config, Vector3d::Zero(), 0.0, seed);
    double largest = 0.0;
    for (int k = 0; k < 5000; ++k)
    {
      if (k % 500 == 0) vehicle.command({rng.uniform3(-3.0, 3.0), 0.0});
      vehicle.advance(kStep);
      largest = std::max(largest, vehicle.sample().a_W.norm());
    }
    // The set-point is within; while the tilt lags behind it, vertical and horizontal mix a little.
    EXPECT_LT(largest, 1.1 * config.max_acceleration_mps2);
    EXPECT_GT(largest, 0.8 * config.max_acceleration_mps2);
  }
}

/// What thrust and drag do is what the body gains, and drag only takes in still air.
TEST(Quadrotor, KeepsItsEnergyBooks)
{
  for (std::uint64_t seed = 1; seed <= 10; ++seed)
  {
    SCOPED_TRACE(seed);
    core::Rng rng(seed);
    const AirframeConfig config = quadrotor();
    Quadrotor vehicle(config, Vector3d::Zero(), 0.0, seed);
    double by_thrust = 0.0, by_drag = 0.0, turnover = 0.0;
    for (int k = 0; k < 8000; ++k)
    {
      if (k % 700 == 0) vehicle.command(anyCommand(rng, 2.0));
      const Vector3d before = vehicle.sample().v_W;
      vehicle.advance(kStep);
      const MotionSample& m = vehicle.sample();
      const Vector3d v = 0.5 * (m.v_W + before);
      const double power = vehicle.thrust() * (m.q_WB * Vector3d::UnitZ()).dot(v);
      by_thrust += kStep * power;
      by_drag -= kStep * config.drag_per_s * before.dot(v);
      turnover += kStep * std::abs(power);
    }
    const MotionSample& m = vehicle.sample();
    const double energy = 0.5 * m.v_W.squaredNorm() + kGravity * m.p_W.z();
    EXPECT_NEAR(energy, by_thrust + by_drag, 1e-6 * turnover);
    EXPECT_LT(by_drag, 0.0);
    EXPECT_GT(turnover, 10.0);
  }
}

TEST(Quadrotor, HoversSteadilyInWind)
{
  AirframeConfig config = quadrotor();
  config.wind_mps = {4.0, -3.0, 0.0};
  Quadrotor steady(config, Vector3d(1.0, 2.0, 3.0), 0.5, 1);
  for (int k = 0; k < 1000; ++k) steady.advance(0.01);
  EXPECT_LT((steady.sample().p_W - Vector3d(1.0, 2.0, 3.0)).norm(), 1e-3) << "trimmed";
  EXPECT_LT(steady.sample().v_W.norm(), 1e-5);
  EXPECT_NEAR(std::tan(tiltOf(steady.sample())), 5.0 * config.drag_per_s / kGravity, 1e-3);

  config.gust_mps = 1.5;
  Quadrotor gusty(config, Vector3d::Zero(), 0.5, 1);
  Vector3d mean = Vector3d::Zero(), square = Vector3d::Zero();
  double speed = 0.0;
  constexpr int kSteps = 60000;
  for (int k = 0; k < kSteps; ++k)
  {
    gusty.advance(0.01);
    mean += gusty.gust() / kSteps;
    square += gusty.gust().cwiseAbs2() / kSteps;
    speed = std::max(speed, gusty.sample().v_W.norm());
  }
  // 600 s are some 200 independent gusts: sigma to 10 %.
  EXPECT_NEAR(std::sqrt(square.x()), config.gust_mps, 0.2 * config.gust_mps);
  EXPECT_NEAR(std::sqrt(square.y()), config.gust_mps, 0.2 * config.gust_mps);
  EXPECT_NEAR(std::sqrt(square.z()), 0.5 * config.gust_mps, 0.2 * config.gust_mps);
  EXPECT_LT(mean.norm(), 0.4 * config.gust_mps);
  EXPECT_LT(speed, 0.5);
  EXPECT_GT(speed, 0.05) << "it is felt";
}

TEST(Quadrotor, GustsAreOnePerSeed)
{
  AirframeConfig config = quadrotor();
  config.gust_mps = 1.0;
  const auto after = [&](std::uint64_t seed)
  {
    Quadrotor vehicle(config, Vector3d::Zero(), 0.0, seed);
    vehicle.advance(2.0);
    return vehicle.sample().p_W;
  };
  EXPECT_EQ(after(3), after(3));
  EXPECT_NE(after(3), after(4));
}

TEST(Quadrotor, TurnsAndAcceleratesAsItsSensorsSay)
{
  AirframeConfig config = quadrotor();
  config.gust_mps = 0.5;
  Quadrotor vehicle(config, Vector3d(0.0, 0.0, 1.5), 0.7, 2);
  Eigen::Quaterniond turned = vehicle.sample().q_WB;
  Vector3d velocity = Vector3d::Zero();
  double heading = 0.0;
  for (int k = 0; k < 2000; ++k)
  {
    if (k % 10 == 0) vehicle.command({{std::sin(0.01 * k), std::cos(0.007 * k), 0.0}, 0.5});
    vehicle.advance(5e-3);
    const MotionSample& m = vehicle.sample();
    turned = turned *
             Eigen::Quaterniond(Eigen::AngleAxisd(m.w_B.norm() * 5e-3, m.w_B.stableNormalized()));
    velocity += 5e-3 * m.a_W;
    const Vector3d x = m.q_WB * Vector3d::UnitX();
    heading = std::atan2(x.y(), x.x());
    ASSERT_LT(turned.angularDistance(m.q_WB), 1e-6);
    ASSERT_LT((velocity - m.v_W).norm(), 1e-9);
  }
  // 10 s at 0.5 rad/s, less lag and delay; tilting does not make it lose its heading.
  EXPECT_NEAR(std::remainder(heading - (0.7 + 0.5 * (10.0 - 0.12)), 2.0 * std::numbers::pi), 0.0,
              0.05);
}

TEST(Quadrotor, RefusesWhatIsNotFiniteAndLagRefusesGusts)
{
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(Quadrotor(quadrotor(), Vector3d(nan, 0.0, 0.0), 0.0, 1), std::invalid_argument);
  Quadrotor vehicle(quadrotor(), Vector3d::Zero(), 0.0, 1);
  EXPECT_THROW(vehicle.command({{0.0, nan, 0.0}, 0.0}), std::invalid_argument);
  AirframeConfig gusty;
  gusty.model = AirframeModel::Lag;
  gusty.gust_mps = 1.0;
  EXPECT_THROW((void)makeVehicle(gusty, Vector3d::Zero(), 0.0, 1), std::invalid_argument);
}
}  // namespace
}  // namespace slalom::simulation
