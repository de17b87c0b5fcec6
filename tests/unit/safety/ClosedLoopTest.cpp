// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "GateFlight.h"

namespace
{
using namespace slalom;
using safety::GateInput;
using safety::GateOutput;
using safety::Intervention;
using Vec3 = Eigen::Vector3d;

core::Vehicle vehicleOf(double speed, double acceleration, double lag)
{
  core::Vehicle vehicle;
  vehicle.max_speed_mps = speed;
  vehicle.max_acceleration_mps2 = acceleration;
  vehicle.velocity_lag_s = lag;
  return vehicle;
}

/// Wants what no planner should want.
class Malice
{
 public:
  Malice(core::Rng& rng, const core::Vehicle& vehicle) : rng_(rng), vehicle_(vehicle) {}

  core::VelocityCommand next(const test::GateFlight& flight)
  {
    if (left_-- <= 0)
    {
      mood_ = rng_.integer(0, 4);
      left_ = rng_.integer(1, 40);
      held_.v_W = 2.0 * vehicle_.max_speed_mps * rng_.direction();
      held_.v_W.z() *= 0.1;
    }
    core::VelocityCommand wanted = held_;
    if (mood_ == 1) wanted.v_W = vehicle_.max_speed_mps * rng_.uniform3(-1.0, 1.0);
    if (mood_ == 2) wanted.v_W = -held_.v_W * (left_ % 2 ? 1.0 : -1.0);
    if (mood_ == 3) wanted.v_W.x() = std::nan("");
    if (mood_ == 4)  // straight at what is nearest
    {
      const auto here = flight.field->sample(flight.motion.p, core::UnknownAs::Free);
      if (here) wanted.v_W = -3.0 * vehicle_.max_speed_mps * here->gradient;
    }
    return wanted;
  }

 private:
  core::Rng& rng_;
  core::Vehicle vehicle_;
  core::VelocityCommand held_;
  int mood_ = 0, left_ = 0;
};

struct Attack
{
  double speed = 1.2, acceleration = 1.0, lag = 0.2, true_lag = 0.2, delay = 0.0;
  int flights = 12, ticks = 400;
  bool lying_plans = false;
  int walkers = 0;  // who walk through trees, and turn
  double graze = safety::SafetyConfig{}.graze_m;
  double distance = 0.0;  // flown, in all
  int evasions = 0;       // ticks that counted on one
};

/// Sets out towards the vehicle, more or less.
void begin(core::MovingObstacle& walker, core::Rng& rng, const test::GateFlight& flight)
{
  Vec3 from = rng.direction();
  from.z() = 0.0;
  walker.p_L = flight.motion.p + rng.uniform(1.0, 4.0) * from.normalized();
  walker.v_L = -rng.uniform(0.2, 1.5) * from.normalized() + 0.2 * rng.uniform3(-1.0, 1.0);
  walker.radius_m = rng.uniform(0.2, 0.5);
  walker.half_axis_m = rng.uniform() < 0.5 ? 0.8 : 0.0;
  walker.sigma_p_m = 0.05;
  walker.sigma_v_mps = 0.1;
}

/// A path from somewhere near to nowhere good, through everything.
safety::StopPath lie(core::Rng& rng, const test::GateFlight& flight)
{
  safety::StopPath path;
  Vec3 p = flight.motion.p, v = flight.motion.v;
  const Vec3 a = 0.8 * flight.vehicle.max_acceleration_mps2 * rng.direction();
  for (int i = 0; i < 60; ++i)
  {
    path.p_L.push_back(p);
    path.v_L.push_back(v);
    p += 0.05 * v;
    v = (v + 0.05 * a)
            .cwiseMax(-flight.vehicle.max_speed_mps)
            .cwiseMin(flight.vehicle.max_speed_mps);
  }
  path.v_L.back().setZero();
  return path;
}

/// What is left of a path one tick later; a tick is a step.
safety::StopPath advanced(safety::StopPath path)
{
  if (path.p_L.size() > 2)
  {
    path.p_L.erase(path.p_L.begin());
    path.v_L.erase(path.v_L.begin());
  }
  return path;
}

double leastClearanceUnder(Attack& attack, std::uint64_t seed)
{
  core::Rng rng(seed);
  test::GateFlight flight;
  flight.vehicle = vehicleOf(attack.speed, attack.acceleration, attack.lag);
  flight.vehicle.command_delay_s = attack.delay;
  flight.true_lag_s = attack.true_lag;
  flight.field = test::makeForest(rng, 50, flight.vehicle.radius_m);
  safety::SafetyConfig config;
  config.graze_m = attack.graze;
  const safety::OutputGate gate(config, flight.vehicle);
  Malice malice(rng, flight.vehicle);
  safety::StopPath plan, kept;
  safety::Evasion evasion;
  std::vector<core::MovingObstacle> walkers(static_cast<std::size_t>(attack.walkers));
  bool relies = false;
  for (int tick = 0; tick < attack.ticks; ++tick)
  {
    GateInput in = flight.input();
    in.wanted = malice.next(flight);
    if (attack.lying_plans)
    {
      // A new lie every five ticks; the gate is handed back what it relied on, as it asks for.
      if (tick % 5 == 0 || plan.p_L.empty()) plan = lie(rng, flight);
      in.plan = &plan;
      if (relies) in.kept_plan = &kept;
    }
    for (core::MovingObstacle& walker : walkers)
    {
      walker.p_L = walker.at(flight.t);
      walker.t = flight.t;
      if (tick % 40 == 0 || (walker.p_L - flight.motion.p).norm() > 4.0) begin(walker, rng, flight);
    }
    in.movers = walkers;
    in.kept_evasion = evasion;
    const GateOutput out = gate.pass(in);
    evasion = out.evasion;
    attack.evasions += evasion.for_s > 0.0;
    relies = out.stop_plan != nullptr;
    if (relies) kept = advanced(*out.stop_plan);
    plan = advanced(plan);
    const Vec3 from = flight.motion.p;
    flight.obey(out.command);
    attack.distance += (flight.motion.p - from).norm();
  }
  return flight.least_clearance_m;
}

double worstOf(Attack& attack, std::uint64_t first_seed)
{
  double least = 1e9;
  for (int i = 0; i < attack.flights; ++i)
    least = std::min(least, leastClearanceUnder(attack, first_seed + i));
  return least;
}

TEST(ClosedLoop, NoCommandMakesAVehicleHitWhenItsLagIsKnown)
{
  std::uint64_t seed = 100;
  for (Attack attack :
       {Attack{}, Attack{.speed = 2.0, .acceleration = 3.0, .lag = 0.25, .true_lag = 0.25},
        Attack{.lag = 0.0, .true_lag = 0.0}, Attack{.delay = 0.04}})
  {
    SCOPED_TRACE(testing::Message() << "speed " << attack.speed << ", lag " << attack.lag
                                    << ", delay " << attack.delay);
    const double least = worstOf(attack, seed += 100);
    EXPECT_GE(least, -1e-6);
    EXPECT_GT(attack.distance, 2.0 * attack.flights);  // the gate did not just stand still
    std::printf("known lag, speed %.1f: least clearance beyond the radius %.4f m, %.0f m flown\n",
                attack.speed, least, attack.distance);
  }
}

TEST(ClosedLoop, NorWithSomebodyWalkingIntoIt)
{
  std::uint64_t seed = 700;
  for (Attack attack :
       {Attack{.ticks = 200, .walkers = 2}, Attack{.true_lag = 0.25, .ticks = 200, .walkers = 1},
        Attack{.speed = 2.0, .acceleration = 3.0, .ticks = 200, .lying_plans = true, .walkers = 2}})
  {
    const double least = worstOf(attack, seed += 100);
    std::printf("walkers: least clearance beyond the radius %.4f m, %.0f m flown, %d evasions\n",
                least, attack.distance, attack.evasions);
    EXPECT_GE(least, attack.lying_plans      ? -attack.graze - 1e-4
                     : attack.true_lag > 0.2 ? -1e-3
                                             : -1e-6);
    EXPECT_GT(attack.evasions, 50);
  }
}

TEST(ClosedLoop, NorWithPlansThatLie)
{
  for (const double graze : {0.0, safety::SafetyConfig{}.graze_m})
  {
    Attack attack{.lying_plans = true, .graze = graze};
    const double least = worstOf(attack, 1000);
    std::printf(
        "lying plans, graze %.2f m: least clearance beyond the radius %.4f m, %.0f m flown\n",
        graze, least, attack.distance);
    EXPECT_GE(least, -graze - 1e-4);
  }
}

/// Braking has a reserve for a lag of 0.25 s; what follows a plan, and a longer lag, costs.
TEST(ClosedLoop, AWrongLagCostsCentimetres)
{
  struct Case
  {
    Attack attack;
    double depth;  // [m]
  };
  std::uint64_t seed = 2000;
  for (Case one : {Case{{.true_lag = 0.25}, 1e-3},
                   {{.true_lag = 0.15}, 1e-3},
                   {{.speed = 2.0, .acceleration = 3.0, .true_lag = 0.25}, 1e-3},
                   {{.true_lag = 0.3}, 0.03},
                   {{.true_lag = 0.25, .lying_plans = true}, 0.09}})
  {
    const double least = worstOf(one.attack, seed += 100);
    std::printf("lag %.2f taken for 0.20, speed %.1f%s: least clearance beyond the radius %.4f m\n",
                one.attack.true_lag, one.attack.speed,
                one.attack.lying_plans ? ", lying plans" : "", least);
    EXPECT_GE(least, -one.depth);
  }
}

/// A slalom in the xy-plane at a pace of its own, and where it can rest.
struct Slalom
{
  double speed, weave, omega;  // [m/s] along x, [m] amplitude, [rad/s]

  [[nodiscard]] Vec3 p(double s) const { return {speed * s, weave * std::sin(omega * s), 0.0}; }
  [[nodiscard]] Vec3 v(double s) const { return {speed, weave * omega * std::cos(omega * s), 0.0}; }
  [[nodiscard]] Vec3 a(double s) const
  {
    return {0.0, -weave * omega * omega * std::sin(omega * s), 0.0};
  }

  /// From parameter s: on at full pace for a while, then slowing down to rest.
  [[nodiscard]] safety::StopPath stop(double s, double slowing) const
  {
    safety::StopPath path;
    double pace = 1.0;
    for (double tau = 0.0; pace > 0.0; tau += path.step_s)
    {
      path.p_L.push_back(p(s));
      path.v_L.push_back(pace * v(s));
      const double next = tau < 2.0 ? 1.0 : std::max(0.0, pace - slowing * path.step_s);
      s += 0.5 * (pace + next) * path.step_s;
      pace = next;
    }
    path.p_L.push_back(p(s));
    path.v_L.push_back(Vec3::Zero());
    return path;
  }

  /// Trunks that leave the way `gap` beside it, most of them no more.
  [[nodiscard]] std::shared_ptr<const test::AnalyticField> forest(core::Rng& rng, double length,
                                                                  double gap) const
  {
    std::vector<Vec3> way;
    for (double s = -2.0; s < length / speed + 4.0; s += 0.01) way.push_back(p(s));
    std::vector<test::Obstacle> trunks;
    for (int i = 0; i < 400; ++i)
    {
      const double radius = rng.uniform(0.08, 0.4);
      Eigen::Vector2d centre(rng.uniform(1.0, length), rng.uniform(-2.0, 2.0));
      const double side = centre.y() > p(centre.x() / speed).y() ? 1.0 : -1.0;
      const auto nearest = [&]
      {
        double least = 1e9;
        for (const Vec3& q : way) least = std::min(least, (q.head<2>() - centre).norm());
        return least - radius;
      };
      // Pushed outwards until it just fits.
      for (int j = 0; j < 60 && nearest() < gap; ++j)
        centre.y() += side * std::max(0.7 * (gap - nearest()), 1e-4);
      if (nearest() >= gap && i % 4 == 0) trunks.push_back(test::VerticalCylinder{centre, radius});
    }
    return std::make_shared<const test::AnalyticField>(
        std::move(trunks), Eigen::AlignedBox3d(Vec3(-5, -6, -3), Vec3(length + 10, 6, 3)));
  }
};

struct Tally
{
  int ticks = 0, touched = 0;
  double worst_error = 0.0, least_clearance = 1e9;
};

Tally flySlalom(const core::Vehicle& vehicle, double speed, double true_lag, double noise,
                std::uint64_t seed, bool gated)
{
  core::Rng rng(seed);
  const double a = 0.7 * vehicle.max_acceleration_mps2;
  const double omega = rng.uniform(1.0, 1.6) * std::sqrt(vehicle.max_acceleration_mps2);
  const Slalom slalom{speed, std::min(a / (omega * omega), 0.9 * vehicle.max_speed_mps / omega),
                      omega};
  const double length = 25.0;
  test::GateFlight flight;
  flight.vehicle = vehicle;
  flight.true_lag_s = true_lag;
  flight.field = slalom.forest(rng, length, vehicle.radius_m + 0.05);
  flight.motion.p = slalom.p(0.0);
  flight.motion.v = slalom.v(0.0);
  flight.last.v_W = slalom.v(0.0) + vehicle.velocity_lag_s * slalom.a(0.0);
  safety::SafetyConfig config;
  config.verify_stop = gated;
  const safety::OutputGate gate(config, vehicle);
  Tally tally;
  Vec3 gust = Vec3::Zero();
  for (double s = 0.0; s * speed < length && tally.ticks < 2000;)
  {
    GateInput in = flight.input();
    const safety::StopPath stop = slalom.stop(s, 0.3 * vehicle.max_acceleration_mps2 / speed);
    in.plan = &stop;
    const double mid = s + 0.5 * flight.period_s;
    in.wanted.v_W = slalom.v(mid) + vehicle.velocity_lag_s * slalom.a(mid) +
                    2.0 * (slalom.p(s) - flight.motion.p);
    const double change = vehicle.max_acceleration_mps2 * flight.period_s;
    in.wanted.v_W = in.wanted.v_W.cwiseMax((flight.last.v_W.array() - change).matrix())
                        .cwiseMin((flight.last.v_W.array() + change).matrix())
                        .cwiseMax(-vehicle.max_speed_mps)
                        .cwiseMin(vehicle.max_speed_mps);
    const GateOutput out = gate.pass(in);
    ++tally.ticks;
    tally.touched += out.intervention != Intervention::None;
    flight.obey(out.command);
    // Gusts: a velocity that comes and goes.
    gust += -0.1 * gust + noise * Vec3(rng.normal(), rng.normal(), 0.0);
    flight.motion.v += gust;
    // The clock of the plan waits for a vehicle that was held up.
    const double error = (flight.motion.p - slalom.p(s + flight.period_s)).norm();
    s += flight.period_s * std::clamp(2.0 - error / 0.2, 0.0, 1.0);
    tally.worst_error = std::max(tally.worst_error, error);
  }
  tally.least_clearance = flight.least_clearance_m;
  return tally;
}

struct Weather
{
  double gusts, true_lag;
};

/* Beside the law itself, what the gate is for: where gusts would push the vehicle too near, it does
 * not make that worse. */
TEST(ClosedLoop, AGoodPlanIsNotTouched)
{
  for (const double speed : {1.0, 1.8})
    for (const Weather& w : {Weather{0.0, 0.2}, Weather{0.0, 0.25}, Weather{0.002, 0.25},
                             Weather{0.004, 0.2}, Weather{0.006, 0.2}})
    {
      const core::Vehicle vehicle = vehicleOf(speed / 0.9, speed > 1.5 ? 3.0 : 1.0, 0.2);
      Tally sum;
      int clear_flights = 0;
      for (std::uint64_t seed = 3000; seed < 3005; ++seed)
      {
        SCOPED_TRACE(testing::Message() << "seed " << seed << ", speed " << speed << ", gusts "
                                        << w.gusts << ", lag " << w.true_lag);
        const Tally gated = flySlalom(vehicle, speed, w.true_lag, w.gusts, seed, true);
        const Tally free = flySlalom(vehicle, speed, w.true_lag, w.gusts, seed, false);
        EXPECT_GE(gated.least_clearance, std::min(free.least_clearance, 0.0) - 0.02);
        if (free.least_clearance < 0.0) continue;
        ++clear_flights;
        sum.ticks += gated.ticks;
        sum.touched += gated.touched;
        sum.worst_error = std::max(sum.worst_error, gated.worst_error);
      }
      std::printf(
          "speed %.1f, gusts %.3f, lag %.2f: %d of %d ticks touched in %d clear flights, "
          "off the plan by up to %.3f m\n",
          speed, w.gusts, w.true_lag, sum.touched, sum.ticks, clear_flights, sum.worst_error);
      EXPECT_LE(sum.touched, 0.01 * sum.ticks);
      EXPECT_GE(clear_flights, w.gusts == 0.0 ? 5 : 1);
    }
}

}  // namespace
