// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <stdexcept>

#include "Observations.h"
#include "slalom/mrpt_io/Velodyne.h"
#include "slalom/simulation/Forest.h"
#include "slalom/simulation/ScriptedFlight.h"
#include "slalom/simulation/SimulatedFlight.h"

namespace slalom::simulation
{
namespace
{
using Eigen::Vector3d;
using mrpt::obs::CObservation;
using mrpt_io::VelodynePacket;
using test::bytesOf;

constexpr double kRate = 200.0;  // [1/s] states of a path

ScriptedFlight script()
{
  return ScriptedFlight::through({{{-19, 0, 2}}, {{-18.0, 0.6, 2.2}}, {{-17.0, 0.0, 2.0}}},
                                 {1.2, 1.0, 0.8, 0.3, 0.2});
}

FlownPath flown(const ScriptedFlight& script, double memory)
{
  FlownPath path(1.0 / kRate, memory, script.at(0.0));
  for (int k = 1; k <= static_cast<int>(script.duration() * kRate); ++k)
    path.append(script.at(k / kRate));
  return path;
}

TEST(FlownPath, IsThePathThatWasFlown)
{
  const ScriptedFlight truth = script();
  const FlownPath path = flown(truth, 100.0);
  EXPECT_NEAR(path.end(), truth.duration(), 1.0 / kRate);
  double moved = 0.0;
  for (double t = 0.0; t < path.end(); t += 7.3e-4)
  {
    const MotionSample a = truth.at(t), b = path.at(t);
    const Eigen::Isometry3d pose = path.pose(t);
    moved = std::max(moved, (a.p_W - truth.at(0.0).p_W).norm());
    ASSERT_LT((a.p_W - b.p_W).norm(), 1e-7) << t;
    ASSERT_LT((a.v_W - b.v_W).norm(), 1e-4) << t;
    ASSERT_LT(a.q_WB.angularDistance(b.q_WB), 1e-4) << t;
    ASSERT_LT((pose.translation() - b.p_W).norm(), 1e-12);
    ASSERT_LT(Eigen::Quaterniond(pose.linear()).angularDistance(b.q_WB), 1e-7);
  }
  EXPECT_GT(moved, 1.5);
}

TEST(FlownPath, ForgetsAndAnswersWithTheNearestItRemembers)
{
  const ScriptedFlight truth = script();
  const FlownPath whole = flown(truth, 100.0), recent = flown(truth, 0.5);
  const double end = whole.end();
  EXPECT_DOUBLE_EQ(recent.end(), end);
  for (double back = 0.0; back <= 0.5; back += 0.013)
    EXPECT_LT((whole.at(end - back).p_W - recent.at(end - back).p_W).norm(), 1e-12);
  EXPECT_EQ(recent.at(end + 10.0).p_W, recent.newest().p_W);
  EXPECT_EQ(recent.at(0.0).p_W, recent.at(-5.0).p_W);
  EXPECT_LT((recent.at(0.0).p_W - whole.at(end - 0.5).p_W).norm(), 0.05);
  EXPECT_THROW(FlownPath(0.0, 1.0, {}), std::invalid_argument);
  EXPECT_THROW(FlownPath(0.1, 0.01, {}), std::invalid_argument);
}

/// A lidar without noise (a ray that just misses would shift that of all others) that does not see
/// the ground so far away that 1e-5 rad move it by more than a unit.
SensorSuite exactLidar()
{
  SensorSuite suite;
  suite.lidar.range_sigma_m = suite.lidar.dropout = 0.0;
  suite.lidar.max_range_m = 20.0;
  return suite;
}

std::vector<CObservation::Ptr> scripted(const World& world, const ScriptedFlight& flight)
{
  std::vector<CObservation::Ptr> all;
  FlightRecorder recorder(world, flight, flight.duration(), exactLidar(), 7);
  while (auto observation = recorder.next()) all.push_back(observation);
  return all;
}

/// Of the returns of a scan: how many are equal, how many within one unit, how many there are.
std::array<int, 3> compared(const CObservation& a, const CObservation& b)
{
  const std::string one = bytesOf(a), two = bytesOf(b);
  EXPECT_EQ(one.size(), two.size());
  std::array<int, 3> count{};
  for (std::size_t k = 0; k + sizeof(VelodynePacket) <= one.size(); k += sizeof(VelodynePacket))
  {
    VelodynePacket p, q;
    std::memcpy(&p, one.data() + k, sizeof p);
    std::memcpy(&q, two.data() + k, sizeof q);
    for (int block = 0; block < VelodynePacket::kBlocks; ++block)
      for (int i = 0; i < VelodynePacket::kReturnsPerBlock; ++i)
      {
        const int difference =
            p.blocks[block].returns[i].distance - q.blocks[block].returns[i].distance;
        count[0] += difference == 0;
        count[1] += std::abs(difference) <= 1;
        ++count[2];
      }
  }
  return count;
}

TEST(FlightRecorder, SeesTheSameOnAPathThatIsFlownAsItGoes)
{
  const World world = World::of(makeForest({}, 3), {}, true);
  const ScriptedFlight flight = script();
  FlownPath path(1.0 / kRate, 0.3, flight.at(0.0));
  FlightRecorder live(world, path, std::numeric_limits<double>::infinity(), exactLidar(), 7);
  std::vector<CObservation::Ptr> arrived;
  std::vector<double> arrival;
  const int states = static_cast<int>(flight.duration() * kRate);
  for (int k = 0; k <= states; ++k)
  {
    if (k > 0) path.append(flight.at(k / kRate));
    for (const auto& observation : live.arrivedBy(path.end()))
    {
      arrived.push_back(observation);
      arrival.push_back(k / kRate);
    }
  }
  std::map<std::string, std::vector<CObservation::Ptr>> told, seen;
  for (const auto& observation : scripted(world, flight))
    told[observation->sensorLabel].push_back(observation);
  for (std::size_t k = 0; k < arrived.size(); ++k)
  {
    const double age =
        arrival[k] + RecordConfig{}.epoch_s - mrpt::Clock::toDouble(arrived[k]->timestamp);
    const bool scan = arrived[k]->sensorLabel == "VELODYNE";
    EXPECT_GE(age, scan ? 0.099 : -1e-6) << arrived[k]->sensorLabel;
    EXPECT_LE(age, (scan ? 0.102 : 0.0) + 1.0 / kRate + 1e-6) << arrived[k]->sensorLabel;
    seen[arrived[k]->sensorLabel].push_back(arrived[k]);
  }
  ASSERT_EQ(told.size(), 5u);
  for (const auto& [label, all] : told)
  {
    SCOPED_TRACE(label);
    // A flight need not end on a state of the path.
    ASSERT_LE(all.size() - seen[label].size(), 1u);
    ASSERT_GT(seen[label].size(), 5u);
    for (std::size_t k = 0; k < seen[label].size(); ++k)
    {
      if (label != "VELODYNE")
      {
        ASSERT_EQ(bytesOf(*seen[label][k]), bytesOf(*all[k])) << k;
        continue;
      }
      // Between states the attitude is some 1e-5 rad off: a fraction of a unit of range, except
      // for the few rays that just miss an edge.
      const auto [equal, near, of] = compared(*seen[label][k], *all[k]);
      EXPECT_GT(equal, 0.97 * of);
      EXPECT_GT(near, 0.999 * of);
    }
  }
}

const SensorSuite& fewRays()
{
  static const SensorSuite suite = []
  {
    SensorSuite s;
    s.lidar.record_every = 5;
    return s;
  }();
  return suite;
}

/// Flies straight ahead past, or into, one tree of radius 0.3 m at (5, y).
FlightTruth pastATree(double y, double speed = 1.5)
{
  const World world = World::of({{{5.0, y}, 0.3, 6.0}}, {}, true);
  AirframeConfig lag;  // it comes to its speed without a rest
  lag.model = AirframeModel::Lag;
  SimulatedFlight flight(world, lag, fewRays(), {{0.0, 0.0, 1.5}, 0.0, 0.35}, 1);
  while (flight.state().p_W.x() < 10.0) (void)flight.advance(0.05, {{speed, 0.0, 0.0}, 0.0});
  return flight.truth();
}

TEST(SimulatedFlight, KnowsTheTrueClearance)
{
  const FlightTruth past = pastATree(1.2);
  EXPECT_NEAR(past.nearest.distance, 0.9, 1e-4);
  EXPECT_NEAR(past.nearest.p_W.x(), 5.0, 0.01);
  EXPECT_FALSE(past.first_contact);
  EXPECT_EQ(past.contacts, 0u);
  EXPECT_NEAR(past.length_m, 10.0, 0.1);
  EXPECT_NEAR(past.max_speed_mps, 1.5, 1e-6);
  EXPECT_LE(past.max_acceleration_mps2, AirframeConfig{}.max_acceleration_mps2 + 1e-9);
}

TEST(SimulatedFlight, SeesEveryContact)
{
  const FlightTruth into = pastATree(0.2);
  ASSERT_TRUE(into.first_contact);
  EXPECT_EQ(into.contacts, 1u) << "in and through is one contact";
  EXPECT_NEAR(into.first_contact->distance, 0.35, 0.01);
  EXPECT_LT(into.first_contact->p_W.x(), 5.0);
  EXPECT_LT(into.nearest.distance, 0.0);
  EXPECT_TRUE(pastATree(0.649).first_contact);
  EXPECT_FALSE(pastATree(0.651).first_contact);

  const World ground = World::of({}, {}, true);
  SimulatedFlight diver(ground, {}, fewRays(), {{0.0, 0.0, 0.5}, 0.0, 0.35}, 1);
  for (int k = 0; k < 20; ++k) (void)diver.advance(0.05, {{0.0, 0.0, -1.0}, 0.0});
  EXPECT_TRUE(diver.truth().first_contact) << "the ground";
}

TEST(SimulatedFlight, RefusesAStartInAnObstacle)
{
  const World world = World::of({{{5.0, 0.0}, 0.3, 6.0}}, {}, true);
  const auto start = [&](double x) {
    SimulatedFlight(world, {}, fewRays(), {{x, 0.0, 1.5}, 0.0, 0.35}, 1);
  };
  EXPECT_THROW(start(5.0), std::invalid_argument);
  EXPECT_THROW(start(4.4), std::invalid_argument);
  EXPECT_NO_THROW(start(4.3));
}

TEST(SimulatedFlight, IsOneFlightPerSeed)
{
  const World world = World::of(makeForest({}, 3), {}, true);
  const auto bytes = [&](std::uint64_t seed)
  {
    SimulatedFlight flight(world, {}, {}, {{-19.0, 0.0, 1.5}, 0.0, 0.35}, seed);
    std::string all;
    for (int k = 0; k < 30; ++k)
      for (const auto& o : flight.advance(0.033, {{0.3, std::sin(0.3 * k), 0.0}, 0.2}))
        all += bytesOf(*o);
    return all;
  };
  const std::string first = bytes(4);
  EXPECT_GT(first.size(), 100000u);
  EXPECT_EQ(first, bytes(4));
  EXPECT_NE(first, bytes(5));
}

TEST(SimulatedFlight, StepsThatDoNotDivideThePeriodAreMadeUpFor)
{
  const World world = World::of({}, {}, false);
  SimulatedFlight flight(world, {}, fewRays(), {{0.0, 0.0, 1.5}, 0.0, 0.35}, 1);
  for (int k = 0; k < 100; ++k) (void)flight.advance(0.0333, {});
  EXPECT_NEAR(flight.time(), 3.33, 1e-9);
  EXPECT_NEAR(flight.truth().t, 3.33, SimulatedFlight::kStep + 1e-9);
}
}  // namespace
}  // namespace slalom::simulation
