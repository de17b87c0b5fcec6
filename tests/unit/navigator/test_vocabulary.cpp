// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <mrpt/io/CMemoryStream.h>
#include <mrpt/kinematics/CVehicleVelCmd_Holo.h>
#include <mrpt/serialization/CArchive.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "MockRobot3D.h"
#include "slalom/core/Rng.h"
#include "slalom/navigator/Navigator.h"

namespace slalom::navigator
{
namespace
{
VelocityCommand3D randomCommand(core::Rng& rng, double size)
{
  return {rng.uniform(-size, size), rng.uniform(-size, size), rng.uniform(-size, size),
          rng.uniform(-size, size)};
}
bool same(const VelocityCommand3D& a, const VelocityCommand3D& b)
{
  return a.vx == b.vx && a.vy == b.vy && a.vz == b.vz && a.wz == b.wz;
}
std::string errorOf(const std::function<void()>& action)
{
  try
  {
    action();
  }
  catch (const std::exception& e)
  {
    return e.what();
  }
  return "no error";
}

TEST(VelocityCommand3D, RoundTripsByName)
{
  core::Rng rng(1);
  for (int i = 0; i < 50; ++i)
  {
    const VelocityCommand3D sent = randomCommand(rng, 1e3);
    mrpt::io::CMemoryStream stream;
    auto archive = mrpt::serialization::archiveFrom(stream);
    archive << sent;
    stream.Seek(0);
    const auto object = archive.ReadObject();
    ASSERT_STREQ(object->GetRuntimeClass()->className, "slalom::navigator::VelocityCommand3D");
    const auto got = std::dynamic_pointer_cast<VelocityCommand3D>(object);
    ASSERT_TRUE(got);
    EXPECT_TRUE(same(sent, *got));
  }
}

TEST(VelocityCommand3D, LimitsHoldAndKeepTheDirection)
{
  core::Rng rng(2);
  int limited = 0;
  for (int i = 0; i < 500; ++i)
  {
    SCOPED_TRACE(i);
    const VelocityCommand3D previous = randomCommand(rng, 2.0);
    const VelocityCommand3D wanted = randomCommand(rng, 2.0);
    const double beta = rng.uniform(0.0, 1.0);
    VelocityCommand3D::TVelCmdParams params;
    params.robotMax_V_mps = rng.uniform(0.2, 3.0);
    params.robotMax_W_radps = rng.uniform(0.2, 3.0);

    VelocityCommand3D command = wanted;
    const double ratio = command.cmdVel_limits(previous, beta, params);
    EXPECT_LE(std::hypot(command.vx, command.vy, command.vz), params.robotMax_V_mps + 1e-12);
    EXPECT_LE(std::abs(command.wz), params.robotMax_W_radps + 1e-12);
    double speed2 = 0.0;
    for (int k = 0; k < 4; ++k)
    {
      const double blend =
          beta * wanted.getVelCmdElement(k) + (1.0 - beta) * previous.getVelCmdElement(k);
      EXPECT_NEAR(command.getVelCmdElement(k), ratio * blend, 1e-12);
      if (k < 3) speed2 += blend * blend;
    }
    const double wz = beta * wanted.wz + (1.0 - beta) * previous.wz;
    const bool inside =
        std::sqrt(speed2) <= params.robotMax_V_mps && std::abs(wz) <= params.robotMax_W_radps;
    EXPECT_EQ(ratio == 1.0, inside);
    if (!inside) ++limited;
    EXPECT_GT(ratio, 0.0);
  }
  EXPECT_GT(limited, 50);
}

TEST(VelocityCommand3D, WithoutLimitsBlendsOnly)
{
  core::Rng rng(3);
  const VelocityCommand3D previous = randomCommand(rng, 9.0), wanted = randomCommand(rng, 9.0);
  VelocityCommand3D command = wanted;
  EXPECT_EQ(command.cmdVel_limits(previous, 1.0, {}), 1.0);
  EXPECT_TRUE(same(command, wanted));
  EXPECT_EQ(command.cmdVel_limits(previous, 0.0, {}), 1.0);
  EXPECT_TRUE(same(command, previous));
  EXPECT_ANY_THROW((void)command.cmdVel_limits(mrpt::kinematics::CVehicleVelCmd_Holo(), 0.5, {}));
}

TEST(VelocityCommand3D, ElementsAndStop)
{
  VelocityCommand3D command;
  EXPECT_TRUE(command.isStopCmd());
  for (int k = 0; k < static_cast<int>(command.getVelCmdLength()); ++k)
  {
    command.setVelCmdElement(k, 1.5);
    EXPECT_EQ(command.getVelCmdElement(k), 1.5);
    EXPECT_FALSE(command.isStopCmd()) << command.getVelCmdDescription(k);
    command.setToStop();
    EXPECT_TRUE(command.isStopCmd());
  }
  for (const int outside : {-1, 4})
  {
    EXPECT_ANY_THROW((void)command.getVelCmdElement(outside));
    EXPECT_ANY_THROW(command.setVelCmdElement(outside, 1.0));
    EXPECT_ANY_THROW((void)command.getVelCmdDescription(outside));
  }
  EXPECT_NE(command.asString().find("wz"), std::string::npos);
}

TEST(RobotInterface3D, AnswersPlanarQuestionsFromThe3DState)
{
  test::MockRobot3D robot;
  robot.state.pose = {1, 2, 3, 0.4, 0.1, -0.1};
  robot.state.twist = {0.1, 0.2, 0.3, 0.4, 0.5, 0.6};
  robot.state.frame = "odom";
  mrpt::math::TPose2D pose, odometry;
  mrpt::math::TTwist2D velocity;
  mrpt::system::TTimeStamp time;
  std::string frame;
  ASSERT_TRUE(robot.getCurrentPoseAndSpeeds(pose, velocity, time, odometry, frame));
  EXPECT_EQ(pose, mrpt::math::TPose2D(1, 2, 0.4));
  EXPECT_EQ(velocity, mrpt::math::TTwist2D(0.1, 0.2, 0.6));
  EXPECT_EQ(frame, "odom");
  robot.tells_state = false;
  EXPECT_FALSE(robot.getCurrentPoseAndSpeeds(pose, velocity, time, odometry, frame));
  EXPECT_FALSE(robot.changeSpeeds(mrpt::kinematics::CVehicleVelCmd_Holo()));
  EXPECT_EQ(robot.commands, 0);
  EXPECT_TRUE(robot.changeSpeeds(VelocityCommand3D(1, 0, 0, 0)));
  EXPECT_EQ(robot.commands, 1);
  EXPECT_TRUE(robot.getStopCmd()->isStopCmd());
  EXPECT_TRUE(robot.getEmergencyStopCmd()->isStopCmd());
}

TEST(NavigationParams3D, CloneIsEqualAndEveryFieldCounts)
{
  NavigationParams3D goal;
  goal.target3D = {1, 2, 3, 0.5, 0, 0};
  goal.waypoints = {{4, 5, 6}};
  goal.allowed_distance_m = 0.7;
  const auto copy = goal.clone();
  EXPECT_TRUE(goal == *copy);
  EXPECT_EQ(copy->target.target_coords, mrpt::math::TPose2D(1, 2, 0.5));
  EXPECT_NEAR(copy->target.targetAllowedDistance, 0.7, 1e-6);

  const std::vector<std::function<void(NavigationParams3D&)>> changes = {
      [](auto& g) { g.target3D.z += 1; },
      [](auto& g) { g.waypoints[0].z += 1; },
      [](auto& g) { g.waypoints.clear(); },
      [](auto& g) { g.allowed_distance_m += 0.1; },
      [](auto& g) { g.target.target_frame_id = "x"; },
      [](auto& g) { g.target.targetIsRelative = true; }};
  for (const auto& change : changes)
  {
    NavigationParams3D other = goal;
    change(other);
    EXPECT_FALSE(goal == other);
  }
  EXPECT_FALSE(goal == mrpt::nav::CAbstractNavigator::TNavigationParams());
  EXPECT_NE(goal.getAsText().find("waypoint"), std::string::npos);
}

TEST(NavigatorFactory, SaysWhatIsWrong)
{
  const std::string unknown = errorOf([] { (void)NavigatorFactory::named("NoSuch"); });
  EXPECT_NE(unknown.find("unknown navigator class 'NoSuch'"), std::string::npos) << unknown;
  EXPECT_NE(unknown.find("is the module loaded"), std::string::npos) << unknown;
  const std::string other = errorOf([] { (void)NavigatorFactory::named("VelocityCommand3D"); });
  EXPECT_NE(other.find("not a navigator factory"), std::string::npos) << other;
  const std::string abstract = errorOf([] { (void)NavigatorFactory::named("NavigatorFactory"); });
  EXPECT_NE(abstract.find("not a navigator factory"), std::string::npos) << abstract;

  const std::string path = errorOf([] { NavigatorFactory::loadModule("/no/such/module.so"); });
  EXPECT_NE(path.find("'/no/such/module.so' not found"), std::string::npos) << path;
  const std::string name = errorOf([] { NavigatorFactory::loadModule("no-such-module"); });
  for (const std::string& directory : NavigatorFactory::pluginDirectories())
    EXPECT_NE(name.find(directory + "/no-such-module.so"), std::string::npos) << name;
}

TEST(NavigatorFactory, RefusesAFileThatIsNoModule)
{
  const auto file = std::filesystem::path(testing::TempDir()) / "not-a-module.so";
  std::ofstream(file) << "text";
  const std::string error = errorOf([&file] { NavigatorFactory::loadModule(file.string()); });
  std::filesystem::remove(file);
  EXPECT_NE(error.find("cannot be loaded"), std::string::npos) << error;
  EXPECT_NE(error.find("not-a-module.so"), std::string::npos) << error;
}

}  // namespace
}  // namespace slalom::navigator
