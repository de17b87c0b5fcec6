// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>

#include "GateFlight.h"

namespace
{
using namespace slalom;
using core::UnknownAs;
using safety::GateInput;
using safety::GateOutput;
using safety::Intervention;
using Vec3 = Eigen::Vector3d;

/// Obstacles in space that is known inside a ball only.
class BallOfKnowledge : public test::AnalyticField
{
 public:
  BallOfKnowledge(std::vector<test::Obstacle> obstacles, const Vec3& centre, double radius)
      : AnalyticField(std::move(obstacles)), centre_(centre), radius_(radius)
  {
  }
  std::optional<core::DistanceSample> sample(const Vec3& p, UnknownAs unknown) const override
  {
    auto here = AnalyticField::sample(p, unknown);
    if (!here || unknown == UnknownAs::Free || toUnknown(p) >= here->distance) return here;
    return core::DistanceSample{toUnknown(p), (centre_ - p).stableNormalized()};
  }
  std::optional<double> lowerBound(const Vec3& p, UnknownAs unknown) const override
  {
    const auto here = sample(p, unknown);
    return here ? std::optional<double>(here->distance) : std::nullopt;
  }

 private:
  double toUnknown(const Vec3& p) const { return radius_ - (p - centre_).norm(); }

  Vec3 centre_;
  double radius_;
};

test::Obstacle wallAt(double x)
{
  return Eigen::AlignedBox3d(Vec3(x, -50, -50), Vec3(x + 1.0, 50, 50));
}

test::GateFlight flightAmong(std::vector<test::Obstacle> obstacles)
{
  test::GateFlight flight;
  flight.field = std::make_shared<const test::AnalyticField>(std::move(obstacles));
  return flight;
}

TEST(Stop, AWallIsApproachedAndNotTouched)
{
  test::GateFlight flight = flightAmong({wallAt(3.0)});
  const safety::OutputGate gate({}, flight.vehicle);
  bool seen = false;
  for (int tick = 0; tick < 300; ++tick)
  {
    GateInput in = flight.input();
    in.wanted.v_W = in.last.v_W.cwiseMin(1.15) + Vec3(0.05, 0.0, 0.0);
    const GateOutput out = gate.pass(in);
    if (out.intervention == Intervention::NoStop)
    {
      EXPECT_NE(out.reason.find("no stop in known free space after this command"),
                std::string::npos);
    }
    seen = seen || out.intervention == Intervention::NoStop;
    EXPECT_GE(out.stop_margin_m, -1e-9);
    flight.obey(out.command);
  }
  EXPECT_TRUE(seen);
  EXPECT_GE(flight.least_clearance_m, -1e-9);
  EXPECT_LE(flight.least_clearance_m, 0.02);  // and it does not stop far away
}

/// A change of command counts over 0.2 s at most, so whoever is asked seldom brakes slowly.
TEST(Stop, AWallIsNotTouchedByAHostThatAsksSeldom)
{
  for (const double period : {0.02, 0.2, 0.35, 0.5, 1.0})
  {
    SCOPED_TRACE(period);
    test::GateFlight flight = flightAmong({wallAt(6.0)});
    flight.period_s = period;
    safety::SafetyConfig config;
    config.map_timeout_s = 2.0;
    const safety::OutputGate gate(config, flight.vehicle);
    while (flight.t < 25.0)
    {
      GateInput in = flight.input();
      in.wanted.v_W = in.last.v_W.cwiseMin(1.1) + Vec3(0.1, 0.0, 0.0);
      flight.obey(gate.pass(in).command);
    }
    EXPECT_GE(flight.least_clearance_m, -1e-9);
    EXPECT_LE(flight.least_clearance_m, 1.0);  // it went there
  }
}

TEST(Stop, TheMarginIsWhatTheStopKeeps)
{
  core::Rng rng(11);
  for (int trial = 0; trial < 60; ++trial)
  {
    SCOPED_TRACE(trial);
    test::GateFlight flight = flightAmong({wallAt(rng.uniform(1.5, 3.0))});
    flight.motion.v = flight.last.v_W = Vec3(rng.uniform(0.2, 1.1), rng.uniform(-1, 1), 0.0);
    const safety::OutputGate gate({}, flight.vehicle);
    GateInput in = flight.input();
    in.wanted = in.last;
    const GateOutput out = gate.pass(in);
    // Braked from the next tick on, the vehicle has at least that clearance.
    flight.obey(out.command);
    for (int tick = 0; tick < 60; ++tick)
    {
      core::VelocityCommand brake;
      for (int i = 0; i < 3; ++i)
        brake.v_W[i] =
            std::copysign(std::max(0.0, std::abs(flight.last.v_W[i]) - 0.05), flight.last.v_W[i]);
      flight.obey(brake);
    }
    EXPECT_GE(flight.least_clearance_m, out.stop_margin_m - 1e-9);
  }
}

TEST(Stop, WithoutVerificationTheWallIsHit)
{
  test::GateFlight flight = flightAmong({wallAt(3.0)});
  safety::SafetyConfig paper;
  paper.verify_stop = false;
  const safety::OutputGate gate(paper, flight.vehicle);
  for (int tick = 0; tick < 100; ++tick)
  {
    GateInput in = flight.input();
    in.wanted.v_W = {1.2, 0.0, 0.0};
    flight.obey(gate.pass(in).command);
  }
  EXPECT_LT(flight.least_clearance_m, 0.0);
}

/// A turn to the left at constant speed, then straight on to rest; begins at the origin along x.
safety::StopPath turn(double radius, double speed)
{
  safety::StopPath path;
  double pace = 1.0;
  for (double s = 0.0; pace > 0.0; s += pace * path.step_s)
  {
    const double angle = std::min(speed * s / radius, 1.2), on = speed * s - radius * angle;
    const Vec3 along(std::cos(angle), std::sin(angle), 0.0);
    path.p_L.push_back(radius * Vec3(std::sin(angle), 1.0 - std::cos(angle), 0.0) + on * along);
    path.v_L.push_back(pace * speed * along);
    if (angle == 1.2) pace = std::max(0.0, pace - 0.5 * path.step_s / speed);
  }
  path.v_L.back().setZero();
  return path;
}

/** A turn of 1 m beside a trunk that leaves it 5 cm and stands in the way of who brakes straight
 * ahead. */
struct Turn
{
  static constexpr double kSpeed = 0.8;

  test::GateFlight flight = flightAmong({test::VerticalCylinder{{0.75, -0.299}, 0.1}});
  safety::StopPath path = turn(1.0, kSpeed);

  Turn()
  {
    flight.motion.v = Vec3(kSpeed, 0.0, 0.0);
    flight.last.v_W = Vec3(kSpeed, flight.vehicle.velocity_lag_s * kSpeed * kSpeed, 0.0);
  }
  /// A tick with the path as a plan.
  [[nodiscard]] GateInput tick() const
  {
    GateInput in = flight.input();
    in.wanted.v_W = in.last.v_W;
    in.plan = &path;
    return in;
  }
  void obey(const GateOutput& out)
  {
    flight.obey(out.command);
    if (path.p_L.size() == 2) return;
    path.p_L.erase(path.p_L.begin());
    path.v_L.erase(path.v_L.begin());
  }
};

TEST(Stop, APlanIsAWayToStopWhereBrakingIsNone)
{
  const Turn turning;
  const safety::OutputGate gate({}, turning.flight.vehicle);
  GateInput in = turning.tick();
  GateOutput out = gate.pass(in);
  EXPECT_EQ(out.intervention, Intervention::None) << out.reason;
  EXPECT_EQ(out.stop_plan, &turning.path);
  EXPECT_GE(out.stop_margin_m, 0.0);
  in.plan = nullptr;
  out = gate.pass(in);
  EXPECT_LT(out.stop_margin_m, -0.02);
  in.kept_plan = &turning.path;
  out = gate.pass(in);
  EXPECT_EQ(out.intervention, Intervention::None) << out.reason;
  EXPECT_EQ(out.stop_plan, &turning.path);
}

/// A plan is a function of time: where it begins is no more than where it was written down from.
TEST(Stop, APlanUnderWayIsFollowedFromWhereItIs)
{
  core::Rng rng(13);
  for (int trial = 0; trial < 30; ++trial)
  {
    SCOPED_TRACE(trial);
    Turn turning;
    turning.flight.vehicle.command_delay_s = rng.uniform(0.0, 0.3);
    const safety::OutputGate gate({}, turning.flight.vehicle);
    GateInput in = turning.tick();
    in.state.t = in.t + turning.flight.vehicle.command_delay_s;  // predicted
    turning.path.begins_s = turning.flight.vehicle.command_delay_s;
    in.map_age_s = 3.0;  // makes it brake along the plan
    const GateOutput whole = gate.pass(in);
    ASSERT_EQ(whole.stop_plan, &turning.path);

    // The same with what lies behind: a straight way that led to its beginning.
    const int gone = static_cast<int>(rng.uniform(1.0, 8.0));
    for (int i = 1; i <= gone; ++i)
    {
      const Vec3 v(Turn::kSpeed, 0.0, 0.0);
      turning.path.p_L.insert(turning.path.p_L.begin(), -i * turning.path.step_s * v);
      turning.path.v_L.insert(turning.path.v_L.begin(), v);
    }
    turning.path.begins_s -= gone * turning.path.step_s;
    const GateOutput under_way = gate.pass(in);
    EXPECT_LE((under_way.command.v_W - whole.command.v_W).norm(), 1e-9);
    EXPECT_NEAR(under_way.stop_margin_m, whole.stop_margin_m, 1e-9);
  }
}

TEST(Stop, LackOfTrustBrakesAlongThePlanWhereStraightBrakingWouldHit)
{
  for (const bool not_finite : {false, true})
  {
    Turn turning;
    const safety::OutputGate gate({}, turning.flight.vehicle);
    for (int tick = 0; tick < 150; ++tick)
    {
      GateInput in = turning.tick();
      in.map_age_s = not_finite ? 0.0 : 3.0;
      if (not_finite) in.wanted.yaw_rate = std::nan("");
      const GateOutput out = gate.pass(in);
      if (tick == 0)
      {
        EXPECT_EQ(out.intervention, not_finite ? Intervention::NotFinite : Intervention::MapTooOld);
        EXPECT_NE(out.reason.find("along a planned stop"), std::string::npos);
      }
      turning.obey(out);
    }
    EXPECT_GE(turning.flight.least_clearance_m, 0.0);
    EXPECT_LE(turning.flight.motion.v.norm(), 1e-3);
  }
}

/// Nothing of a plan is believed: a path through the trunk is no way to stop.
TEST(Stop, APlanThatHitsIsRefused)
{
  Turn turning;
  for (Vec3& p : turning.path.p_L) p.y() = 0.0;
  for (Vec3& v : turning.path.v_L) v.y() = 0.0;
  const safety::OutputGate gate({}, turning.flight.vehicle);
  EXPECT_LT(gate.pass(turning.tick()).stop_margin_m, -0.02);
}

TEST(Stop, InsideAnObstacleTheWayOutIsOpenAndTheWayInIsNot)
{
  // A phantom: the vehicle stands 0.2 m inside a wall that is not there.
  for (const double depth : {0.2, -0.1})
  {
    SCOPED_TRACE(depth);
    const test::GateFlight start = flightAmong({wallAt(-depth)});
    for (const double direction : {-1.0, 1.0})
    {
      test::GateFlight flight = start;
      const safety::OutputGate gate({}, flight.vehicle);
      for (int tick = 0; tick < 60; ++tick)
      {
        GateInput in = flight.input();
        in.wanted.v_W = Vec3(direction, 0.0, 0.0);
        flight.obey(gate.pass(in).command);
      }
      if (direction < 0.0)
      {
        EXPECT_LT(flight.motion.p.x(), -1.0);
      }
      else
      {
        EXPECT_LE(flight.motion.p.x(), 1e-6);
      }
    }
  }
}

TEST(Stop, FromUnknownSpaceTheWayIsOpenButNotIntoWhatIsSeen)
{
  // Nothing is known but a wall ahead and a ball of known space that the vehicle is outside of.
  test::GateFlight flight;
  const auto field = std::make_shared<const BallOfKnowledge>(
      std::vector<test::Obstacle>{wallAt(1.0)}, Vec3(-3.0, 0.0, 0.0), 2.0);
  flight.field = field;
  const safety::OutputGate gate({}, flight.vehicle);
  for (const double direction : {1.0, -1.0})
  {
    test::GateFlight one = flight;
    for (int tick = 0; tick < 100; ++tick)
    {
      GateInput in = one.input();
      in.wanted.v_W = Vec3(direction, 0.0, 0.0);
      one.obey(gate.pass(in).command);
    }
    EXPECT_GE(one.least_clearance_m, -1e-9);
    if (direction < 0.0)
    {
      EXPECT_LT(one.motion.p.x(), -2.0);  // into the known
    }
    else
    {
      EXPECT_LE(one.motion.p.x(), 1e-6);  // not deeper into the unknown
    }
  }
}

TEST(Stop, UnknownSpaceIsAsTheConfigurationSays)
{
  for (const UnknownAs unknown : {UnknownAs::Occupied, UnknownAs::Free})
  {
    test::GateFlight flight;
    flight.field =
        std::make_shared<const BallOfKnowledge>(std::vector<test::Obstacle>{}, Vec3::Zero(), 2.0);
    safety::SafetyConfig config;
    config.unknown = unknown;
    const safety::OutputGate gate(config, flight.vehicle);
    for (int tick = 0; tick < 150; ++tick)
    {
      GateInput in = flight.input();
      in.wanted.v_W = Vec3(1.0, 0.0, 0.0);
      flight.obey(gate.pass(in).command);
    }
    if (unknown == UnknownAs::Free)
    {
      EXPECT_GT(flight.motion.p.x(), 4.0);
    }
    else
    {
      EXPECT_LE(flight.motion.p.norm(), 2.0 - flight.vehicle.radius_m + 1e-9);
    }
  }
}

core::MovingObstacle moverAt(const Vec3& p, const Vec3& v)
{
  return {.id = 1,
          .t = 0.0,
          .p_L = p,
          .v_L = v,
          .radius_m = 0.3,
          .sigma_p_m = 0.05,
          .sigma_v_mps = 0.05};
}

TEST(Stop, AMovingObstacleIsNamedAndGivenWay)
{
  // It crosses ahead; flown on blindly the vehicle would meet it.
  test::GateFlight flight = flightAmong({});
  flight.motion.v = flight.last.v_W = Vec3(1.0, 0.0, 0.0);
  const safety::OutputGate gate({}, flight.vehicle);
  const core::MovingObstacle mover = moverAt({3.0, -3.0, 0.0}, {0.0, 1.0, 0.0});
  bool named = false;
  double nearest = 1e9;
  for (int tick = 0; tick < 160; ++tick)
  {
    GateInput in = flight.input();
    in.movers = std::span(&mover, 1);
    in.wanted.v_W = Vec3(1.0, 0.0, 0.0);
    const GateOutput out = gate.pass(in);
    named = named || out.intervention == Intervention::MovingObstacle;
    flight.obey(out.command);
    nearest = std::min(
        nearest, (flight.motion.p - mover.at(flight.t)).norm() - 0.3 - flight.vehicle.radius_m);
  }
  EXPECT_TRUE(named);
  EXPECT_GE(nearest, 0.0);
  EXPECT_GT(flight.motion.p.x(), 3.0);  // and it goes on afterwards
}

TEST(Stop, AMoverThatIsFarAwayOrLeavingChangesNothing)
{
  test::GateFlight flight = flightAmong({});
  flight.motion.v = flight.last.v_W = Vec3(1.0, 0.0, 0.0);
  const safety::OutputGate gate({}, flight.vehicle);
  for (const core::MovingObstacle& mover :
       {moverAt({20, 0, 0}, {-1, 0, 0}), moverAt({-1.5, 0, 0}, {-1, 0, 0})})
  {
    GateInput in = flight.input();
    in.movers = std::span(&mover, 1);
    in.wanted = in.last;
    EXPECT_EQ(gate.pass(in).intervention, Intervention::None);
  }
}

}  // namespace
