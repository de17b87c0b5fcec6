// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <vector>

#include "FlightHarness.h"

namespace slalom
{
namespace
{
using engine::EngineStatus;
using test::FlightHarness;

constexpr double kLength = 18.0;

engine::Mission straightMission()
{
  Eigen::Matrix3Xd goal(3, 1);
  goal << kLength, 0.0, 1.5;
  return {goal};
}

const Eigen::Vector3d kStart(0.0, 0.0, 1.5);

class Forest : public testing::TestWithParam<std::uint64_t>
{
};

TEST_P(Forest, IsCrossedWithoutContact)
{
  const test::AnalyticField world = test::flightForest(GetParam(), 0.12, kLength);
  const engine::EngineConfig config = test::flightConfig();
  FlightHarness harness(world, config);
  const test::FlightOutcome flight = harness.fly(kStart, straightMission(), 60.0);
  EXPECT_EQ(flight.status, EngineStatus::GoalReached) << toString(flight.status);
  EXPECT_GE(flight.min_clearance_m, config.vehicle.radius_m);
  EXPECT_LE(flight.mean_error_m, 0.25);
  EXPECT_LE(flight.length_m, 1.3 * kLength);
  EXPECT_LE(flight.max_speed_mps, 1.01 * config.vehicle.max_speed_mps);
  EXPECT_TRUE(flight.finite);
  EXPECT_EQ(flight.statistics.fallback_brake, 0u);
}

INSTANTIATE_TEST_SUITE_P(Seeds, Forest, testing::Range<std::uint64_t>(1, 7));

TEST(Flight, OfABlindPlannerIsSeenToFail)
{
  // The same harness with a sensor that sees nothing: the check above must be able to fail.
  int contacts = 0;
  for (std::uint64_t seed = 1; seed < 7; ++seed)
  {
    const test::AnalyticField world = test::flightForest(seed, 0.12, kLength);
    FlightHarness harness(world, test::flightConfig());
    harness.blind = true;
    if (harness.fly(kStart, straightMission(), 60.0).min_clearance_m <
        test::flightConfig().vehicle.radius_m)
      ++contacts;
  }
  EXPECT_GE(contacts, 4);
}

TEST(Flight, IsReproducible)
{
  const test::AnalyticField world = test::flightForest(3, 0.12, kLength);
  const auto hash = [&]
  {
    FlightHarness harness(world, test::flightConfig());
    return harness.fly(kStart, straightMission(), 8.0).hash;
  };
  EXPECT_EQ(hash(), hash());
}

TEST(Flight, RunsTheSameStepsInThreads)
{
  const test::AnalyticField world = test::flightForest(3, 0.12, kLength);
  engine::EngineConfig config = test::flightConfig();
  config.rates.threaded = true;
  FlightHarness harness(world, config);
  const test::FlightOutcome flight = harness.fly(kStart, straightMission(), 5.0);
  EXPECT_TRUE(flight.finite);
  EXPECT_GT(flight.statistics.map_updates, 0u);
}

TEST(Flight, EndsBlockedBeforeAGoalInsideATrunk)
{
  const test::AnalyticField world({test::VerticalCylinder{{kLength, 0.0}, 0.75}});
  FlightHarness harness(world, test::flightConfig());
  const test::FlightOutcome flight = harness.fly(kStart, straightMission(), 60.0);
  EXPECT_EQ(flight.status, EngineStatus::GoalBlocked) << toString(flight.status);
  EXPECT_GE(flight.min_clearance_m, test::flightConfig().vehicle.radius_m);
  EXPECT_LE(flight.min_clearance_m, 1.3) << "it must come near";
}

/// The centre of a trunk is a goal as any other: the verdict comes once and stays.
class GoalInATrunk : public testing::TestWithParam<std::uint64_t>
{
};

TEST_P(GoalInATrunk, EndsBlockedOnceAndStaysSo)
{
  SCOPED_TRACE(GetParam());
  core::Rng rng(GetParam());
  const double radius = rng.uniform(0.2, 1.5);
  const Eigen::Vector3d goal(rng.uniform(7.0, 11.0), rng.uniform(-2.0, 2.0), 1.5);
  std::vector<test::Obstacle> trees{test::VerticalCylinder{goal.head<2>(), radius}};
  while (trees.size() < 12)
  {
    const Eigen::Vector2d c(rng.uniform(0.0, kLength + 3.0), rng.uniform(-6.0, 6.0));
    const double r = rng.uniform(0.2, 0.4);
    if (c.norm() > r + 1.5 && (c - goal.head<2>()).norm() > radius + r + 0.2)
      trees.push_back(test::VerticalCylinder{c, r});
  }
  const test::AnalyticField world(std::move(trees));
  FlightHarness harness(world, test::flightConfig());
  harness.azimuths = 120;
  std::vector<std::string> events;
  double blocked_t = std::numeric_limits<double>::infinity();
  Eigen::Vector3d blocked_p = Eigen::Vector3d::Zero();
  harness.listener = [&](const core::CycleRecord& cycle, const Eigen::Vector3d& p)
  {
    for (const core::Event& event : cycle.events)
    {
      events.push_back(event.name);
      if (event.name != "GOAL_BLOCKED") continue;
      blocked_t = std::min(blocked_t, cycle.t);
      blocked_p = p;
    }
  };
  harness.over = [&](double t, EngineStatus) { return t > blocked_t + 10.0; };
  const test::FlightOutcome flight = harness.fly(kStart, {goal}, 60.0);
  EXPECT_EQ(flight.status, EngineStatus::GoalBlocked) << toString(flight.status);
  EXPECT_EQ(std::count(events.begin(), events.end(), "GOAL_BLOCKED"), 1);
  ASSERT_FALSE(events.empty());
  EXPECT_EQ(events.back(), "GOAL_BLOCKED") << "and nothing after it";
  EXPECT_LT((harness.position() - blocked_p).norm(), 0.3) << "it stays where it is";
  EXPECT_LT(harness.velocity().norm(), 0.02);
  EXPECT_LT((harness.position() - goal).norm(), radius + 2.0) << "it must come near";
  EXPECT_GE(flight.min_clearance_m, test::flightConfig().vehicle.radius_m);
}
INSTANTIATE_TEST_SUITE_P(Seeds, GoalInATrunk, testing::Range<std::uint64_t>(1, 11));

TEST(Flight, ABlockedGoalThatIsClearedIsFlownTo)
{
  const test::AnalyticField trunk({test::VerticalCylinder{{8.0, 0.0}, 0.5}});
  bool there = true;
  const auto solid = [&](const Eigen::Vector3d& p)
  { return there ? trunk.signedDistance(p) : p.z() + 10.0; };
  FlightHarness harness(test::FlightWorld::of(solid), test::flightConfig());
  harness.azimuths = 120;
  double blocked_t = std::numeric_limits<double>::infinity();
  harness.over = [&](double t, EngineStatus status)
  {
    if (status == EngineStatus::GoalBlocked) blocked_t = std::min(blocked_t, t);
    there = t < blocked_t + 2.0;
    return status == EngineStatus::GoalReached;
  };
  const test::FlightOutcome flight = harness.fly(kStart, {Eigen::Vector3d(8.0, 0.0, 1.5)}, 60.0);
  EXPECT_LT(blocked_t, 40.0);
  EXPECT_EQ(flight.status, EngineStatus::GoalReached) << toString(flight.status);
}

TEST(Flight, OfALoopIsNotOverBeforeItIsFlown)
{
  const test::AnalyticField world({test::VerticalCylinder{{3.0, 2.0}, 0.3}});
  FlightHarness harness(world, test::flightConfig());
  Eigen::Matrix3Xd loop(3, 4);
  loop << 6, 6, 0, 0, 0, 5, 5, 0, 1.5, 1.5, 1.5, 1.5;
  const test::FlightOutcome flight = harness.fly(kStart, {loop}, 60.0);
  EXPECT_EQ(flight.status, EngineStatus::GoalReached) << toString(flight.status);
  EXPECT_GE(flight.length_m, 18.0);
  EXPECT_GE(flight.min_clearance_m, test::flightConfig().vehicle.radius_m);
}

TEST(Flight, ToWhereTheVehicleIsIsOverAtOnce)
{
  const test::AnalyticField world({});
  FlightHarness harness(world, test::flightConfig());
  const test::FlightOutcome flight = harness.fly(kStart, {Eigen::Matrix3Xd(kStart)}, 10.0);
  EXPECT_EQ(flight.status, EngineStatus::GoalReached) << toString(flight.status);
  EXPECT_LE(flight.length_m, 0.2);
}

/// A flight whose vehicle obeys `delay` late, and what the engine is told of that.
test::FlightOutcome flyDelayed(std::uint64_t seed, double delay, double configured)
{
  const test::AnalyticField world = test::flightForest(seed, 0.12, kLength);
  engine::EngineConfig config = test::flightConfig();
  config.vehicle.velocity_lag_s = FlightHarness::kLag;  // the delay alone is looked at
  config.vehicle.command_delay_s = configured;
  FlightHarness harness(world, config);
  harness.azimuths = 90;
  harness.command_delay_s = delay;
  return harness.fly(kStart, straightMission(), 60.0);
}

class Latency : public testing::TestWithParam<int>
{
 protected:
  const double delay_s = 1e-3 * GetParam();
  const double radius_m = core::Vehicle{}.radius_m;
};

TEST_P(Latency, ThatIsKnownCostsLittle)
{
  // Paths differ a little with the delay: one flight alone says little of so small an error.
  static const std::vector<std::uint64_t> seeds{1, 3, 4};
  static const double without = std::accumulate(
      seeds.begin(), seeds.end(), 0.0,
      [](double sum, std::uint64_t seed) { return sum + flyDelayed(seed, 0.0, 0.0).mean_error_m; });
  double with = 0.0;
  for (const std::uint64_t seed : seeds)
  {
    SCOPED_TRACE(seed);
    const test::FlightOutcome flight = flyDelayed(seed, delay_s, delay_s);
    EXPECT_EQ(flight.status, EngineStatus::GoalReached) << toString(flight.status);
    EXPECT_GE(flight.min_clearance_m, radius_m);
    with += flight.mean_error_m;
  }
  // Positions differentiated to velocities are not better known than that.
  const double measurable = 0.01 * double(seeds.size());
  EXPECT_LT(with, 1.2 * std::max(without, measurable));
  RecordProperty("mean_error_um", static_cast<int>(1e6 * with / double(seeds.size())));
  RecordProperty("without_delay_um", static_cast<int>(1e6 * without / double(seeds.size())));
}

TEST_P(Latency, ThatIsNotKnownStaysFreeOfContact)
{
  EXPECT_GE(flyDelayed(4, delay_s, 0.0).min_clearance_m, radius_m);
}

INSTANTIATE_TEST_SUITE_P(Milliseconds, Latency, testing::Values(50, 100, 150, 200));

/// A ball of 0.4 m that would meet the vehicle half way, among some trees.
struct Encounter
{
  Eigen::Vector3d v;
  double offset;  ///< [m] by which it would miss
  static constexpr double kMeet_s = 9.0, kRadius = 0.4;
  [[nodiscard]] Eigen::Vector3d at(double t) const
  {
    return Eigen::Vector3d(8.5, offset, 1.5) + (t - kMeet_s) * v;
  }
};

/// Least gap between vehicle and ball [m], and how the flight ended.
std::pair<double, EngineStatus> flyPast(const Encounter& encounter, bool tracked)
{
  const test::AnalyticField trees(
      {test::VerticalCylinder{{4.0, 3.0}, 0.3}, test::VerticalCylinder{{12.0, -3.0}, 0.3},
       test::VerticalCylinder{{9.0, 4.5}, 0.3}, test::VerticalCylinder{{7.0, -4.0}, 0.3}});
  double now = 0.0, gap = 1e9;
  const auto distance = [&](const Eigen::Vector3d& p) {
    return std::min(trees.signedDistance(p), (p - encounter.at(now)).norm() - Encounter::kRadius);
  };
  test::FlightWorld world{
      distance, [distance](const Eigen::Vector3d& from, const Eigen::Vector3d& along, double range)
      {
        double s = 0.0;
        for (double d = 1.0; s < range && d > 1e-3; s += d) d = distance(from + s * along);
        return std::min(s, range);
      }};
  engine::EngineConfig config = test::flightConfig();
  config.tracking.enabled = tracked;
  FlightHarness harness(world, config);
  harness.faults.world = [&](double t, const Eigen::Vector3d& p)
  {
    now = t;
    gap =
        std::min(gap, (p - encounter.at(t)).norm() - Encounter::kRadius - config.vehicle.radius_m);
  };
  const test::FlightOutcome flight = harness.fly(kStart, straightMission(), 60.0);
  return {gap, flight.status};
}

TEST(Flight, GivesWayToWhatMoves)
{
  int met = 0, flights = 0, contacts = 0;
  for (const double speed : {0.3, 0.6, 1.0})
    for (const double course : {0.5 * std::numbers::pi, -0.5 * std::numbers::pi, std::numbers::pi,
                                0.75 * std::numbers::pi})
    {
      SCOPED_TRACE(testing::Message() << speed << " m/s, course " << course);
      const Encounter encounter{speed * Eigen::Vector3d(std::cos(course), std::sin(course), 0.0),
                                0.1};
      const auto [gap, status] = flyPast(encounter, true);
      EXPECT_EQ(status, EngineStatus::GoalReached) << toString(status);
      EXPECT_GE(gap, 0.0);
      contacts += gap < 0.0;
      ++flights;
      if (speed == 1.0) met += flyPast(encounter, false).first < gap;
    }
  EXPECT_GE(met, 2) << "tracking has to be worth something";
  RecordProperty("flights", flights);
  RecordProperty("contacts", contacts);
}

TEST(Flight, BetweenWallsSeesNothingMove)
{
  // Walls end where the range ends, behind columns, and in gaps: what is seen of them slides along.
  const auto box = [](double x0, double y0, double z0, double x1, double y1, double z1)
  { return Eigen::AlignedBox3d(Eigen::Vector3d(x0, y0, z0), Eigen::Vector3d(x1, y1, z1)); };
  const test::AnalyticField court(
      {box(-4.0, -6.2, 0.0, 22.0, -6.0, 3.0), box(-4.0, 6.0, 0.0, 6.0, 6.2, 3.0),
       box(8.0, 4.0, 0.0, 22.0, 4.2, 3.0), box(3.0, -4.0, 0.0, 3.3, -2.2, 3.0),
       box(9.0, -5.0, 0.0, 11.0, -4.8, 2.0), box(-4.0, -20.0, -1.0, 22.0, 20.0, 0.0),
       test::VerticalCylinder{{6.0, -2.5}, 0.3}, test::VerticalCylinder{{12.0, 2.0}, 0.3},
       test::VerticalCylinder{{14.0, -1.8}, 0.3}});
  FlightHarness harness(court, test::flightConfig());
  harness.azimuths = 720;
  std::size_t movers = 0;
  double largest = 0.0;
  harness.listener = [&](const core::CycleRecord& cycle, const Eigen::Vector3d&)
  {
    movers += cycle.movers.size();
    for (const auto& mover : cycle.movers) largest = std::max(largest, mover.radius_m);
  };
  const test::FlightOutcome flight = harness.fly(kStart, straightMission(), 60.0);
  EXPECT_EQ(flight.status, EngineStatus::GoalReached) << toString(flight.status);
  EXPECT_EQ(movers, 0u) << "the largest of " << largest << " m";
}

TEST(Flight, AMoverBesideAWallDoesNotTakeTheWallAlong)
{
  const test::AnalyticField court(
      {Eigen::AlignedBox3d(Eigen::Vector3d(-4, -4.7, 0), Eigen::Vector3d(22, -4.5, 3)),
       test::VerticalCylinder{{9.0, 3.5}, 0.3}, test::VerticalCylinder{{14.0, 3.0}, 0.3}});
  double now = 0.0;
  // Comes from the open, walks along the wall and touches it.
  const auto walker = [&now]
  {
    const double y = std::max(-4.1, -2.0 - 0.3 * now);
    return Eigen::Vector3d(3.0 + 0.8 * now, y, 1.5);
  };
  const auto distance = [&](const Eigen::Vector3d& p)
  { return std::min(court.signedDistance(p), (p - walker()).norm() - 0.4); };
  test::FlightWorld world{
      distance, [distance](const Eigen::Vector3d& from, const Eigen::Vector3d& along, double range)
      {
        double s = 0.0;
        for (double d = 1.0; s < range && d > 1e-3; s += d) d = distance(from + s * along);
        return std::min(s, range);
      }};
  FlightHarness harness(world, test::flightConfig());
  harness.azimuths = 720;
  harness.faults.world = [&](double t, const Eigen::Vector3d&) { now = t; };
  std::size_t movers = 0;
  double largest = 0.0;
  harness.listener = [&](const core::CycleRecord& cycle, const Eigen::Vector3d&)
  {
    movers += cycle.movers.size();
    for (const auto& mover : cycle.movers) largest = std::max(largest, mover.radius_m);
  };
  const test::FlightOutcome flight = harness.fly(kStart, straightMission(), 60.0);
  EXPECT_EQ(flight.status, EngineStatus::GoalReached) << toString(flight.status);
  EXPECT_GT(movers, 0u) << "it has to be seen";
  EXPECT_LE(largest, 0.9);
}

TEST(Flight, StandsStillWithoutAMap)
{
  engine::Engine engine(test::flightConfig());
  engine.setMission(straightMission());
  for (int k = 0; k < 40; ++k)
  {
    core::PoseFix fix;
    fix.t = 0.05 * k;
    fix.T_WB = Eigen::Translation3d(kStart) * Eigen::Quaterniond::Identity();
    engine.add(fix);
    const core::CycleRecord cycle = engine.step(0.05 * k);
    EXPECT_EQ(cycle.command.v_W.norm(), 0.0) << cycle.reason;
  }
}

TEST(Flight, RefusesAContradictoryConfiguration)
{
  engine::EngineConfig config = test::flightConfig();
  config.global_planner.clearance_m = 0.2;
  EXPECT_ANY_THROW(engine::Engine{config});
}

}  // namespace
}  // namespace slalom
