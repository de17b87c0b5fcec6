// SPDX-License-Identifier: BSD-3-Clause
// The shipped flight is what datasets/README.md says it is.
#include <gtest/gtest.h>

#include <filesystem>

#include "slalom/simulation/FlightRecorder.h"
#include "slalom/simulation/ScriptedFlight.h"
#include "slalom/simulation/World.h"
#include "slalom/spline/WaypointFile.h"

namespace slalom::simulation
{
namespace
{
const std::filesystem::path kFolder =
    std::filesystem::path(SLALOM_SOURCE_DIR) / "datasets/forest_slalom";

TEST(ForestSlalom, FlownPathKeepsItsDistanceAndTheMissionDoesNot)
{
  const World world = World::load(kFolder / "world.csv");
  const ScriptedFlight flown = ScriptedFlight::load(kFolder / "flown.csv", {});
  EXPECT_GT(flown.duration(), 40.0);
  EXPECT_LT(flown.duration(), 60.0);
  EXPECT_FALSE(firstContact(world, flown, flown.duration(), 0.78));
  const ScriptedFlight mission = ScriptedFlight::load(kFolder / "mission.csv", {});
  EXPECT_TRUE(firstContact(world, mission, mission.duration(), 0.0))
      << "the mission must run through trees, or there is nothing to refine";
}

TEST(ForestSlalom, EndsAtTheGoalOfTheMission)
{
  const auto mission = spline::readWaypoints(kFolder / "mission.csv");
  const auto flown = spline::readWaypoints(kFolder / "flown.csv");
  const auto apart = [&](Eigen::Index i, Eigen::Index k)
  { return (mission.points_W.col(i) - flown.points_W.col(k)).norm(); };
  EXPECT_LT(apart(0, 0), 0.3);
  EXPECT_LT(apart(mission.points_W.cols() - 1, flown.points_W.cols() - 1), 0.3);
}
}  // namespace
}  // namespace slalom::simulation
