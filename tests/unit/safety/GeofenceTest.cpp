// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>

#include "GateFlight.h"

namespace
{
using namespace slalom;
using safety::GateInput;
using safety::GateOutput;
using safety::Intervention;
using Vec3 = Eigen::Vector3d;

const Vec3 kLow(-3.0, -2.0, 0.5), kHigh(4.0, 2.5, 3.0);
const Vec3 kDrift(0.7, -0.3, 0.2);  // world less local frame

safety::SafetyConfig fenced()
{
  safety::SafetyConfig config;
  config.fence_min_x_m = kLow.x();
  config.fence_min_y_m = kLow.y();
  config.fence_min_z_m = kLow.z();
  config.fence_max_x_m = kHigh.x();
  config.fence_max_y_m = kHigh.y();
  config.fence_max_z_m = kHigh.z();
  return config;
}

/// A flight in the open; the fence is in world coordinates, maps and motion are not.
struct FencedFlight : test::GateFlight
{
  explicit FencedFlight(const Vec3& from_W)
  {
    field = std::make_shared<const test::AnalyticField>(std::vector<test::Obstacle>{});
    motion.p = from_W - kDrift;
  }
  [[nodiscard]] Vec3 p_W() const { return motion.p + kDrift; }
  [[nodiscard]] GateInput fencedInput(const Vec3& wanted) const
  {
    GateInput in = input();
    in.state.p_W = p_W();
    in.wanted.v_W = wanted;
    return in;
  }
  [[nodiscard]] double room() const
  {
    return std::min((p_W() - kLow).minCoeff(), (kHigh - p_W()).minCoeff());
  }
};

TEST(Geofence, IsNeverCrossed)
{
  for (std::uint64_t seed = 0; seed < 12; ++seed)
  {
    SCOPED_TRACE(seed);
    core::Rng rng(seed);
    FencedFlight flight(Vec3(0.0, 0.0, 1.5));
    flight.vehicle.velocity_lag_s = flight.true_lag_s = seed % 3 == 0 ? 0.0 : 0.2;
    flight.vehicle.command_delay_s = seed % 2 ? 0.04 : 0.0;
    const safety::OutputGate gate(fenced(), flight.vehicle);
    Vec3 wanted = Vec3::Zero();
    bool met = false;
    double nearest = 1e9;
    for (int tick = 0; tick < 600; ++tick)
    {
      if (rng.uniform() < 0.02) wanted = 3.0 * rng.direction();
      const GateOutput out = gate.pass(flight.fencedInput(wanted));
      met = met || out.intervention == Intervention::Geofence;
      flight.obey(out.command);
      nearest = std::min(nearest, flight.room());
      ASSERT_GE(flight.room(), -1e-9) << "tick " << tick;
    }
    EXPECT_TRUE(met);
    EXPECT_LE(nearest, 0.05);  // the room inside is used
  }
}

TEST(Geofence, HoldsWhereTheLagIsLongerThanAssumed)
{
  FencedFlight flight(Vec3(0.0, 0.0, 1.5));
  flight.true_lag_s = 0.25;
  const safety::OutputGate gate(fenced(), flight.vehicle);
  for (int tick = 0; tick < 200; ++tick)
  {
    flight.obey(gate.pass(flight.fencedInput({2.0, 0.0, 0.0})).command);
    ASSERT_GE(flight.room(), -1e-3);
  }
}

TEST(Geofence, OutsideOnlyTheWayBackIsOpen)
{
  core::Rng rng(7);
  for (int trial = 0; trial < 40; ++trial)
  {
    SCOPED_TRACE(trial);
    const int axis = trial % 3;
    const bool above = trial % 2;
    Vec3 from(0.0, 0.0, 1.5);
    from[axis] = above ? kHigh[axis] + 1.0 : kLow[axis] - 1.0;
    FencedFlight flight(from);
    const safety::OutputGate gate(fenced(), flight.vehicle);
    // Whatever is wanted, it does not get farther out ...
    for (int tick = 0; tick < 60; ++tick)
    {
      flight.obey(gate.pass(flight.fencedInput(3.0 * rng.direction())).command);
      ASSERT_GE(flight.room(), -1.0 - 1e-9);
    }
    // ... and the way back is free.
    Vec3 back = Vec3::Zero();
    back[axis] = above ? -1.0 : 1.0;
    for (int tick = 0; tick < 80; ++tick) flight.obey(gate.pass(flight.fencedInput(back)).command);
    EXPECT_GT(flight.room(), 0.0);
  }
}

TEST(Geofence, OffUnlessSet)
{
  FencedFlight flight(Vec3(0.0, 0.0, 1.5));
  const safety::OutputGate gate({}, flight.vehicle);
  for (int tick = 0; tick < 200; ++tick)
    flight.obey(gate.pass(flight.fencedInput({1.2, 0.0, 0.0})).command);
  EXPECT_GT(flight.p_W().x(), kHigh.x() + 2.0);
}

}  // namespace
