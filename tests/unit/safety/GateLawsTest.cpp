// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "GateFlight.h"

namespace
{
using namespace slalom;
using safety::GateInput;
using safety::GateOutput;
using safety::Intervention;
using safety::SafetyConfig;
using Vec3 = Eigen::Vector3d;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// A flight in the open, at a speed, with nothing wrong.
GateInput calm(const Vec3& velocity = Vec3::Zero())
{
  static const auto field = std::make_shared<const test::AnalyticField>(
      std::vector<test::Obstacle>{test::Sphere{{50, 0, 0}, 1.0}});
  GateInput in;
  in.t = in.state.t = 10.0;
  in.state.v_W = in.last.v_W = in.wanted.v_W = velocity;
  in.plan_age_s = 0.0;
  in.field = field;
  return in;
}

/// A double of any kind: tame, odd, or whatever its bits say.
double wild(core::Rng& rng)
{
  constexpr double kOdd[] = {kNaN, kInfinity, -kInfinity, 1e300, -1e300, 0.0, -0.0, 5e-324};
  const int kind = rng.integer(0, 9);
  if (kind < 6) return rng.uniform(-2.0, 2.0);
  if (kind == 6) return kOdd[rng.integer(0, 7)];
  if (kind == 7) return rng.uniform(-1e4, 1e4);
  return std::bit_cast<double>(rng.bits());
}

Vec3 wild3(core::Rng& rng)
{
  const double x = wild(rng), y = wild(rng), z = wild(rng);
  return {x, y, z};
}

/// Checks what holds for any input. @param last as the gate documents to read it
void expectLawful(const GateInput& in, const GateOutput& out, const core::Vehicle& vehicle)
{
  ASSERT_TRUE(out.command.v_W.allFinite());
  ASSERT_TRUE(std::isfinite(out.command.yaw_rate));
  EXPECT_LE(std::abs(out.command.yaw_rate), vehicle.max_yaw_rate_radps);
  const double dt = in.dt > 0.0 ? std::min(in.dt, 0.2) : 0.0;
  for (int i = 0; i < 3; ++i)
  {
    double last = std::isfinite(in.last.v_W[i]) ? in.last.v_W[i] : in.state.v_W[i];
    if (!std::isfinite(last)) last = 0.0;
    last = std::clamp(last, -vehicle.max_speed_mps, vehicle.max_speed_mps);
    EXPECT_LE(std::abs(out.command.v_W[i]), vehicle.max_speed_mps);
    EXPECT_LE(std::abs(out.command.v_W[i] - last), vehicle.max_acceleration_mps2 * dt + 1e-12);
  }
  EXPECT_EQ(out.reason.empty(), out.intervention == Intervention::None);
  EXPECT_TRUE(std::isfinite(out.stop_margin_m));
}

/// Any bits anywhere: field by field with some probability, so that some inputs get deep.
GateInput wildInput(core::Rng& rng, safety::StopPath& plan,
                    std::vector<core::MovingObstacle>& movers)
{
  const double odds = rng.uniform(0.0, 1.0);
  const auto some = [&] { return rng.uniform() < odds; };
  GateInput in = calm();
  in.wanted.v_W = rng.uniform3(-1, 1);
  in.last.v_W = rng.uniform3(-1, 1);
  if (some()) in.t = wild(rng);
  if (some()) in.state.t = wild(rng);
  if (some()) in.state.p_L = wild3(rng);
  if (some()) in.state.p_W = wild3(rng);
  if (some()) in.state.v_W = wild3(rng);
  if (some()) in.state_age_s = wild(rng);
  if (some()) in.map_age_s = wild(rng);
  if (some()) in.plan_age_s = wild(rng);
  if (some()) in.wanted = {wild3(rng), wild(rng)};
  if (some()) in.last = {wild3(rng), wild(rng)};
  if (some()) in.dt = wild(rng);
  if (some()) in.hold_s = wild(rng);
  in.needs_map = rng.uniform() < 0.7;
  if (some()) in.field = nullptr;
  plan = {};
  for (int i = rng.integer(0, 12); i > 0; --i)
  {
    plan.p_L.push_back(some() ? wild3(rng) : rng.uniform3(-1, 1));
    plan.v_L.push_back(some() ? wild3(rng) : rng.uniform3(-1, 1));
  }
  if (some()) plan.v_L.push_back(Vec3::Zero());
  if (some()) plan.step_s = wild(rng);
  if (some()) in.plan = &plan;
  if (some()) in.kept_plan = &plan;
  movers.clear();
  for (int i = rng.integer(0, 3); i > 0; --i)
  {
    core::MovingObstacle mover{.t = in.t, .p_L = rng.uniform3(-2, 2), .radius_m = 0.3};
    if (some()) mover.p_L = wild3(rng);
    if (some()) mover.v_L = wild3(rng);
    if (some()) mover.t = wild(rng);
    if (some()) mover.radius_m = wild(rng);
    if (some()) mover.sigma_p_m = wild(rng);
    if (some()) mover.sigma_v_mps = wild(rng);
    movers.push_back(mover);
  }
  in.movers = movers;
  return in;
}

TEST(GateLaws, AnyBitsGiveALawfulCommand)
{
  core::Rng rng(1);
  SafetyConfig fenced;
  fenced.fence_max_x_m = fenced.fence_max_y_m = fenced.fence_max_z_m = 1.5;
  fenced.fence_min_x_m = -1.5;
  SafetyConfig blind;
  blind.verify_stop = false;
  core::Vehicle quick, late, odd;
  quick.velocity_lag_s = 0.0;
  late.velocity_lag_s = 2.0;
  late.command_delay_s = 0.5;
  odd.max_speed_mps = 30.0;
  odd.max_acceleration_mps2 = 0.05;
  const auto trees = test::makeForest(rng, 30, 0.35);
  safety::StopPath plan;
  std::vector<core::MovingObstacle> movers;
  for (const core::Vehicle& vehicle : {core::Vehicle{}, quick, late, odd})
    for (const SafetyConfig& config : {SafetyConfig{}, fenced, blind})
    {
      const safety::OutputGate gate(config, vehicle);
      for (int i = 0; i < 1500; ++i)
      {
        GateInput in = wildInput(rng, plan, movers);
        if (in.field && i % 2) in.field = trees;
        SCOPED_TRACE(i);
        expectLawful(in, gate.pass(in), vehicle);
        if (HasFatalFailure()) return;
      }
    }
}

TEST(GateLaws, ThePassIsAFunctionOfItsInput)
{
  core::Rng rng(2);
  const safety::OutputGate gate({}, {});
  safety::StopPath plan;
  std::vector<core::MovingObstacle> movers;
  for (int i = 0; i < 500; ++i)
  {
    const GateInput in = wildInput(rng, plan, movers);
    const GateOutput a = gate.pass(in), b = gate.pass(in);
    EXPECT_EQ(a.command.v_W, b.command.v_W);
    EXPECT_EQ(a.intervention, b.intervention);
    EXPECT_EQ(a.reason, b.reason);
  }
}

TEST(GateLaws, WhatIsInOrderPassesUnchanged)
{
  core::Rng rng(3);
  const core::Vehicle vehicle;
  const safety::OutputGate gate({}, vehicle);
  for (int i = 0; i < 500; ++i)
  {
    GateInput in = calm(rng.uniform3(-1.0, 1.0));
    in.wanted = {in.last.v_W + 0.05 * rng.uniform3(-1.0, 1.0), rng.uniform(-1.0, 1.0)};
    const GateOutput out = gate.pass(in);
    EXPECT_EQ(out.intervention, Intervention::None) << out.reason;
    EXPECT_LE((out.command.v_W - in.wanted.v_W).norm(), 1e-12);
    EXPECT_EQ(out.command.yaw_rate, in.wanted.yaw_rate);
    EXPECT_GT(out.stop_margin_m, 1.0);
  }
}

TEST(GateLaws, BeyondALimitTheNearestInsidePasses)
{
  const safety::OutputGate gate({}, {});
  GateInput in = calm({1.18, 0.0, 0.0});
  in.wanted = {{9.0, 0.01, -9.0}, -7.0};
  const GateOutput out = gate.pass(in);
  EXPECT_EQ(out.intervention, Intervention::Limits);
  EXPECT_LE((out.command.v_W - Vec3(1.2, 0.01, -0.05)).norm(), 1e-12);
  EXPECT_EQ(out.command.yaw_rate, -1.0);
}

struct Fault
{
  const char* name;
  Intervention expected;
  void (*make)(GateInput&);
};
// In the order in which they are named when several meet.
const Fault kFaults[] = {
    {"not finite", Intervention::NotFinite, [](GateInput& in) { in.wanted.v_W.y() = kNaN; }},
    {"state", Intervention::StateTooOld, [](GateInput& in) { in.state_age_s = 0.51; }},
    {"map", Intervention::MapTooOld, [](GateInput& in) { in.map_age_s = 1.01; }},
    {"plan", Intervention::PlanTooOld, [](GateInput& in) { in.plan_age_s = 2.01; }},
};

TEST(GateLaws, EveryFaultBrakesForItsOwnReason)
{
  const safety::OutputGate gate({}, {});
  std::vector<std::string> reasons;
  for (const Fault& fault : kFaults)
  {
    SCOPED_TRACE(fault.name);
    GateInput in = calm({0.8, -0.4, 0.02});
    in.wanted.yaw_rate = 0.5;
    fault.make(in);
    const GateOutput out = gate.pass(in);
    EXPECT_EQ(out.intervention, fault.expected);
    EXPECT_LE((out.command.v_W - Vec3(0.75, -0.35, 0.0)).norm(), 1e-12);
    EXPECT_EQ(out.command.yaw_rate, 0.0);
    EXPECT_EQ(std::count(reasons.begin(), reasons.end(), out.reason), 0);
    reasons.push_back(out.reason);
  }
}

TEST(GateLaws, OfSeveralFaultsTheFirstIsNamed)
{
  const safety::OutputGate gate({}, {});
  for (std::size_t first = 0; first < std::size(kFaults); ++first)
  {
    GateInput in = calm({0.8, 0.0, 0.0});
    for (std::size_t i = first; i < std::size(kFaults); ++i) kFaults[i].make(in);
    EXPECT_EQ(gate.pass(in).intervention, kFaults[first].expected);
  }
}

TEST(GateLaws, NothingKnownIsAsBadAsTooOld)
{
  const safety::OutputGate gate({}, {});
  const auto of = [&](auto change)
  {
    GateInput in = calm({0.8, 0.0, 0.0});
    change(in);
    return gate.pass(in).intervention;
  };
  EXPECT_EQ(of([](GateInput& in) { in.field = nullptr; }), Intervention::MapTooOld);
  EXPECT_EQ(of([](GateInput& in) { in.map_age_s = kNaN; }), Intervention::MapTooOld);
  EXPECT_EQ(of([](GateInput& in) { in.state_age_s = kNaN; }), Intervention::StateTooOld);
  EXPECT_EQ(of([](GateInput& in) { in.plan_age_s = kInfinity; }), Intervention::PlanTooOld);
  EXPECT_EQ(of([](GateInput& in) { in.state.p_L.x() = kNaN; }), Intervention::NotFinite);
  EXPECT_EQ(of([](GateInput& in) { in.state.v_W.x() = 1e200; }), Intervention::NotFinite);
}

TEST(GateLaws, AHostThatFliesWithoutAMapIsNotStoppedForIt)
{
  const safety::OutputGate gate({}, {});
  GateInput in = calm({0.8, 0.0, 0.0});
  in.needs_map = false;
  in.field = nullptr;
  in.map_age_s = in.plan_age_s = kInfinity;
  EXPECT_EQ(gate.pass(in).intervention, Intervention::None);
  in.state_age_s = 1.0;
  EXPECT_EQ(gate.pass(in).intervention, Intervention::StateTooOld);
}

TEST(GateLaws, WhoBrakesByItselfIsNotOverruled)
{
  const safety::OutputGate gate({}, {});
  GateInput in = calm();
  in.plan_age_s = kInfinity;
  EXPECT_EQ(gate.pass(in).intervention, Intervention::None);
}

TEST(GateLaws, BrakingEndsAtRest)
{
  const safety::OutputGate gate({}, {});
  GateInput in = calm({1.2, -0.7, 0.33});
  in.map_age_s = 9.0;
  for (int tick = 0; tick < 24; ++tick) in.last = gate.pass(in).command;
  EXPECT_EQ(in.last.v_W, Vec3::Zero());
}

TEST(GateLaws, BadSettingsThrowAtConstruction)
{
  const auto make = [](auto change)
  {
    SafetyConfig config;
    core::Vehicle vehicle;
    change(config, vehicle);
    return safety::OutputGate(config, vehicle);
  };
  using C = SafetyConfig;
  using V = core::Vehicle;
  EXPECT_NO_THROW(make([](C&, V&) {}));
  EXPECT_THROW(make([](C& c, V&) { c.state_timeout_s = kNaN; }), std::invalid_argument);
  EXPECT_THROW(make([](C& c, V&) { c.map_timeout_s = -1.0; }), std::invalid_argument);
  EXPECT_THROW(make([](C& c, V&) { c.fence_min_x_m = c.fence_max_x_m = 1.0; }),
               std::invalid_argument);
  EXPECT_THROW(make([](C& c, V&) { c.fence_max_z_m = kInfinity; }), std::invalid_argument);
  EXPECT_THROW(make([](C&, V& v) { v.max_speed_mps = 0.0; }), std::invalid_argument);
  EXPECT_THROW(make([](C&, V& v) { v.velocity_lag_s = -0.1; }), std::invalid_argument);
}

}  // namespace
