// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>
#include <stdexcept>
#include <string>

#include "slalom/core/Rng.h"
#include "slalom/spline/WaypointFile.h"

namespace slalom::spline
{
namespace
{
/// A waypoint file of the test that runs.
class WaypointFile : public testing::Test
{
 protected:
  ~WaypointFile() override
  {
    std::error_code ignored;
    std::filesystem::remove(path_, ignored);
  }
  Waypoints read(const std::string& text) const
  {
    std::ofstream(path_, std::ios::binary) << text;
    return readWaypoints(path_);
  }
  std::string complaint(const std::string& text) const
  {
    try
    {
      (void)read(text);
    }
    catch (const std::runtime_error& error)
    {
      return error.what();
    }
    return "";
  }

  const std::filesystem::path path_ = std::filesystem::path(testing::TempDir()) /
                                      ("waypoints_" + std::to_string(getpid()) + ".csv");
};

TEST_F(WaypointFile, EverySpellingOfTheSamePathReadsTheSame)
{
  for (const std::uint64_t seed : {1, 2, 3})
  {
    SCOPED_TRACE(seed);
    core::Rng rng(seed);
    std::string plain, with_yaw = "x,y,z,yaw_rad\r\n# turns\r\n\r\n", path = "7, forest0";
    const Eigen::Index count = 1 + static_cast<Eigen::Index>(rng.uniform(0.0, 8.0));
    Eigen::Matrix3Xd points(3, count);
    Eigen::VectorXd yaw(count);
    for (Eigen::Index i = 0; i < count; ++i)
    {
      // Binary fractions are exact in six decimals.
      for (int k = 0; k < 3; ++k) points(k, i) = std::round(rng.uniform(-640.0, 640.0)) / 64.0;
      yaw[i] = std::round(rng.uniform(-200.0, 200.0)) / 64.0;
      const auto s = [](double value) { return std::to_string(value); };
      const std::string p = s(points(0, i)) + ", " + s(points(1, i)) + "," + s(points(2, i));
      plain += p + "\n";
      with_yaw += " " + p + ",\t" + s(yaw[i]) + "\r\n";
      path += "," + p;
    }
    EXPECT_EQ(read(plain).points_W, points);
    EXPECT_FALSE(read(plain).yaw);
    EXPECT_EQ(read("x,y,z\n" + plain).points_W, points);
    EXPECT_EQ(read(with_yaw).points_W, points);
    EXPECT_EQ(read(with_yaw).yaw, yaw);
    EXPECT_EQ(read(path).points_W, points);
    EXPECT_EQ(read("path_id,world,x1,y1,z1\n" + path + ",,,\n").points_W, points);
    EXPECT_FALSE(read(path).yaw);
  }
}

TEST_F(WaypointFile, NamesFileLineAndValueOfAMistake)
{
  const std::pair<const char*, const char*> cases[] = {
      {"0,0,1\n1,zwei,3\n", ":2: 'zwei' is not a finite number"},
      {"0,0,1\n\n1,nan,3\n", ":3: 'nan'"},
      {"0,0,1\n1,,3\n", ":2: ''"},
      {"x,y,z\nx,y,z\n", ":2: 'x'"},
      {"0,0\n", ":1: 2 fields"},
      {"0,0,1\n0,1\n", ":2: 2 fields"},
      {"0,0,1\n,,\n", ":2: 0 fields"},
      {",,\n0,0,1\n", ":1: 0 fields"},
      {"0,0,1,0\n0,0,1\n", ":2: either all waypoints have a yaw"},
      {"0,0,1\n0,0,1,0\n", ":2: either all waypoints have a yaw"},
      {"7,w,0,0,1,2,0\n", ":1: 7 fields"},
      {"7,w,0,0,1\n8,w,9,9,9\n", ":2: a second path"},
      {"0,0,1\n7,w,0,0,1,2,0,1\n", ":2: 8 fields"},
      {"7,w,0,0,oops\n", ":1: 'oops'"},
      {"# nothing\n", "no waypoint"},
      {"x,y,z\n", "no waypoint"},
      {"", "no waypoint"},
  };
  for (const auto& [text, says] : cases)
  {
    SCOPED_TRACE(text);
    const std::string message = complaint(text);
    EXPECT_TRUE(message.starts_with(path_.string())) << message;
    EXPECT_NE(message.find(says), std::string::npos) << message;
  }
  EXPECT_NE(complaint(std::string("0,0,1\n0,\0,1\n", 12)).find(":2: not a text file"),
            std::string::npos);
  EXPECT_THROW((void)readWaypoints("/nonexistent/file.csv"), std::runtime_error);
  EXPECT_THROW((void)readWaypoints(testing::TempDir()), std::runtime_error);
}
}  // namespace
}  // namespace slalom::spline
