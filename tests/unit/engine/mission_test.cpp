// SPDX-License-Identifier: BSD-3-Clause
#include "slalom/engine/Mission.h"

#include <gtest/gtest.h>

#include <fstream>

namespace slalom::engine
{
namespace
{
std::filesystem::path fileWith(const std::string& text)
{
  const auto path = std::filesystem::path(testing::TempDir()) /
                    (std::string("mission_") +
                     testing::UnitTest::GetInstance()->current_test_info()->name() + ".csv");
  std::ofstream(path) << text;
  return path;
}

std::string complaint(const std::string& text)
{
  try
  {
    (void)readMission(fileWith(text));
  }
  catch (const std::runtime_error& error)
  {
    return error.what();
  }
  return "";
}

TEST(Mission, ReadsWaypointsWithHeaderCommentsAndYaw)
{
  const Mission mission =
      readMission(fileWith("x,y,z,yaw_rad\n# a comment\n0,0,1\n\n1.5, -2, 1.25, 0.7\n"));
  ASSERT_EQ(mission.waypoints_W.cols(), 2);
  EXPECT_EQ(mission.waypoints_W.col(1), Eigen::Vector3d(1.5, -2, 1.25));
}

TEST(Mission, ReadsADatasetRow)
{
  const Mission mission =
      readMission(fileWith("path_id,world,x1,y1,z1\n7, forest0, 0,0,1, 2,0,1, 4,1,1\n8,w,9,9,9\n"));
  ASSERT_EQ(mission.waypoints_W.cols(), 3);
  EXPECT_EQ(mission.waypoints_W.col(2), Eigen::Vector3d(4, 1, 1));
}

TEST(Mission, NamesFileLineAndValueOfAMistake)
{
  EXPECT_NE(complaint("0,0,1\n1,zwei,3\n").find(".csv:2: 'zwei' is not a finite number"),
            std::string::npos);
  EXPECT_NE(complaint("0,0,1\n1,nan,3\n").find("'nan'"), std::string::npos);
  EXPECT_NE(complaint("0,0\n").find(":1: expected x,y,z"), std::string::npos);
  EXPECT_NE(complaint("# nothing\n").find("no waypoint"), std::string::npos);
  EXPECT_THROW((void)readMission("/nonexistent/file.csv"), std::runtime_error);
}

}  // namespace
}  // namespace slalom::engine
