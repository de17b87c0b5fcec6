// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <mrpt/config/CConfigFileMemory.h>

#include <cmath>

#include "MockRobot3D.h"
#include "StraightNavigator.h"
#include "slalom/core/Rng.h"

namespace slalom::navigator
{
namespace
{
using mrpt::math::TPoint3D;
using mrpt::nav::CAbstractNavigator;
using Status = test::StraightNavigator::StepResult::Status;

NavigationParams3D goalAt(const TPoint3D& p, std::vector<TPoint3D> waypoints = {})
{
  NavigationParams3D goal;
  goal.target3D = {p.x, p.y, p.z, 0, 0, 0};
  goal.waypoints = std::move(waypoints);
  return goal;
}

class StateMachine : public testing::Test
{
 protected:
  StateMachine()
  {
    navigator.initialize();
    navigator.logging_enable_console_output = false;
  }
  void navigate(const NavigationParams3D& goal) { navigator.navigate(&goal); }
  void step(double dt = 0.05)
  {
    robot.advance(dt);
    navigator.navigationStep();
  }
  /// Steps until the state changes; false if that takes more than `limit` steps.
  bool leaves(CAbstractNavigator::TState state, int limit = 2000)
  {
    for (int i = 0; i < limit; ++i)
    {
      step();
      if (navigator.getCurrentState() != state) return true;
    }
    return false;
  }
  auto current() const { return navigator.getCurrentState(); }

  test::MockRobot3D robot;
  test::StraightNavigator navigator{robot};
};

TEST_F(StateMachine, ReachesGoalsInEveryDirection)
{
  core::Rng rng(11);
  for (int i = 0; i < 40; ++i)
  {
    SCOPED_TRACE(i);
    Eigen::Vector3d d = i % 4 == 0 ? Eigen::Vector3d::UnitZ() : rng.direction();
    d *= rng.uniform(1.0, 20.0) * (i % 8 == 4 ? -1.0 : 1.0);
    const TPoint3D from = robot.state.pose.translation();
    const TPoint3D to = from + TPoint3D(d.x(), d.y(), d.z());
    NavigationParams3D goal = goalAt(to);
    goal.allowed_distance_m = rng.uniform(0.1, 0.6);
    robot.log.clear();
    navigate(goal);
    ASSERT_EQ(current(), CAbstractNavigator::NAVIGATING);
    step();
    ASSERT_EQ(current(), CAbstractNavigator::NAVIGATING) << "a goal " << d.norm() << " m away";
    ASSERT_TRUE(leaves(CAbstractNavigator::NAVIGATING));
    ASSERT_EQ(current(), CAbstractNavigator::IDLE);
    EXPECT_LT(robot.distanceTo(to), goal.allowed_distance_m);
    EXPECT_TRUE(robot.flown.isStopCmd());
    EXPECT_EQ(robot.count("start"), 1);
    EXPECT_EQ(robot.count("end"), 1);
    EXPECT_EQ(robot.count("GOAL_REACHED"), 1);
    EXPECT_EQ(robot.count("error end"), 0);
  }
  EXPECT_EQ(navigator.goals, 40);
  EXPECT_EQ(navigator.ends, 40);
}

TEST_F(StateMachine, ALongClimbRaisesNoAlarm)
{
  navigator.params_abstract_navigator.alarm_seems_not_approaching_target_timeout = 3.0;
  navigate(goalAt({0, 0, 100}));
  ASSERT_TRUE(leaves(CAbstractNavigator::NAVIGATING, 3000));
  EXPECT_EQ(current(), CAbstractNavigator::IDLE);
  EXPECT_EQ(robot.count("way blocked"), 0);
}

TEST_F(StateMachine, AStalledVehicleRaisesTheAlarmInTime)
{
  for (const TPoint3D& to : {TPoint3D(10, 0, 0), TPoint3D(0, 0, 10)})
  {
    navigator.params_abstract_navigator.alarm_seems_not_approaching_target_timeout = 3.0;
    robot.log.clear();
    robot.jammed = true;
    navigate(goalAt(to));
    step();
    const double since = robot.t;
    ASSERT_TRUE(leaves(CAbstractNavigator::NAVIGATING));
    EXPECT_EQ(current(), CAbstractNavigator::NAV_ERROR);
    EXPECT_NEAR(robot.t - since, 3.0, 0.11);
    EXPECT_EQ(navigator.getErrorReason().error_code, CAbstractNavigator::ERR_CANNOT_REACH_TARGET);
    EXPECT_TRUE(robot.flown.isStopCmd()) << "must stop in the same step";
    EXPECT_EQ(robot.count("way blocked"), 1);
    step();
    EXPECT_EQ(robot.count("error end"), 1);
  }
  navigator.params_abstract_navigator.alarm_seems_not_approaching_target_timeout = 0.0;  // off
  navigate(goalAt({10, 0, 0}));
  EXPECT_FALSE(leaves(CAbstractNavigator::NAVIGATING));
}

TEST_F(StateMachine, TimeInSuspensionIsNoStall)
{
  navigator.params_abstract_navigator.alarm_seems_not_approaching_target_timeout = 3.0;
  navigate(goalAt({10, 0, 0}));
  for (int i = 0; i < 20; ++i) step();
  navigator.suspend();
  EXPECT_TRUE(robot.flown.isStopCmd());
  EXPECT_FALSE(leaves(CAbstractNavigator::SUSPENDED, 100));
  navigator.resume();
  ASSERT_TRUE(leaves(CAbstractNavigator::NAVIGATING));
  EXPECT_EQ(current(), CAbstractNavigator::IDLE);
  EXPECT_EQ(robot.count("start"), 1);
}

struct Failure
{
  std::string name;
  std::function<void(test::MockRobot3D&, test::StraightNavigator&)> cause, cure;
};
std::vector<Failure> failures()
{
  using Robot = test::MockRobot3D;
  using Navigator = test::StraightNavigator;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto cure_command = [](Robot&, Navigator& n) { n.disturb_command = nullptr; };
  return {
      {"state unavailable", [](Robot& r, Navigator&) { r.tells_state = false; },
       [](Robot& r, Navigator&) { r.tells_state = true; }},
      {"state not finite", [nan](Robot& r, Navigator&) { r.state.pose.z = nan; },
       [](Robot& r, Navigator&) { r.state.pose.z = 0.0; }},
      {"other frame", [](Robot& r, Navigator&) { r.state.frame = "odom"; },
       [](Robot& r, Navigator&) { r.state.frame = "map"; }},
      {"command refused", [](Robot& r, Navigator&) { r.obeys = false; },
       [](Robot& r, Navigator&) { r.obeys = true; }},
      {"command not finite",
       [nan](Robot&, Navigator& n) { n.disturb_command = [nan](auto& c) { c.command.wz = nan; }; },
       cure_command},
      {"planner failed",
       [](Robot&, Navigator& n)
       { n.disturb_command = [](auto& c) { c.status = Status::Failed, c.detail = "no way"; }; },
       cure_command},
      {"planner threw",
       [](Robot&, Navigator& n)
       { n.disturb_command = [](auto&) { throw std::runtime_error("bug"); }; },
       cure_command},
      {"sensing threw",
       [](Robot&, Navigator& n) { n.disturb_sense = [] { throw std::runtime_error("bug"); }; },
       [](Robot&, Navigator& n) { n.disturb_sense = nullptr; }},
      {"callback threw",
       [](Robot& r, Navigator&) { r.during_command = [] { throw std::runtime_error("bug"); }; },
       [](Robot& r, Navigator&) { r.during_command = nullptr; }}};
}

TEST_F(StateMachine, EveryFailureStopsAndStaysUntilANewGoal)
{
  for (const bool rethrow : {false, true})
    for (const int steps_before : {0, 5})
      for (const Failure& failure : failures())
      {
        SCOPED_TRACE(failure.name + " after " + std::to_string(steps_before) + " steps, rethrow " +
                     std::to_string(rethrow));
        navigator.enableRethrowNavExceptions(rethrow);
        if (steps_before == 0) step();  // so that the base knows it was idle
        robot.log.clear();
        navigate(goalAt(robot.state.pose.translation() + TPoint3D(100, 0, 0)));
        for (int i = 0; i < steps_before; ++i) step();
        failure.cause(robot, navigator);
        robot.advance(0.05);
        try
        {
          navigator.navigationStep();
        }
        catch (const std::exception&)
        {
          EXPECT_TRUE(rethrow);
        }
        EXPECT_EQ(current(), CAbstractNavigator::NAV_ERROR);
        EXPECT_FALSE(navigator.getErrorReason().error_msg.empty());
        EXPECT_TRUE(robot.flown.isStopCmd());
        EXPECT_GE(robot.count("emergency stop"), 1);

        failure.cure(robot, navigator);
        const int commands = robot.commands;
        EXPECT_FALSE(leaves(CAbstractNavigator::NAV_ERROR, 10));
        EXPECT_EQ(robot.commands, commands);
        EXPECT_EQ(robot.count("error end"), 1);
        EXPECT_EQ(robot.count("FAILED"), 1);
        EXPECT_EQ(robot.count("end"), 0);

        robot.log.clear();
        navigate(goalAt(robot.state.pose.translation() + TPoint3D(0, 1, 1)));
        EXPECT_EQ(navigator.getErrorReason().error_code, CAbstractNavigator::ERR_NONE);
        ASSERT_TRUE(leaves(CAbstractNavigator::NAVIGATING));
        EXPECT_EQ(current(), CAbstractNavigator::IDLE);
        EXPECT_EQ(robot.count("start"), 1);
        EXPECT_EQ(robot.count("end"), 1);
      }
}

// The state diagram of MRPT's header, walked at random next to a model of it.
TEST_F(StateMachine, FollowsTheDiagramForAnyVerbs)
{
  using S = CAbstractNavigator::TState;
  for (std::uint64_t seed = 1; seed <= 20; ++seed)
  {
    SCOPED_TRACE(seed);
    core::Rng rng(seed);
    robot.log.clear();
    S model = S::IDLE;
    bool start_due = false;
    int starts = 0, ends = 0, errors = 0;
    navigator.cancel();
    step();
    for (int i = 0; i < 300; ++i)
    {
      const int commands = robot.commands;
      int expected_commands = 0;
      const int verb = rng.integer(0, 8);
      SCOPED_TRACE("step " + std::to_string(i) + " verb " + std::to_string(verb));
      const bool fails = verb == 6, arrives = verb == 7;
      if (verb == 0)
      {
        if (model != S::NAVIGATING) start_due = true;
        model = S::NAVIGATING;
        navigate(goalAt({1e4, 0, 0}));
      }
      else if (verb == 1)
      {
        model = S::IDLE;
        navigator.cancel();
      }
      else if (verb == 2)
      {
        if (model == S::NAVIGATING) model = S::SUSPENDED;
        navigator.suspend();
      }
      else if (verb == 3)
      {
        if (model == S::SUSPENDED) model = S::NAVIGATING;
        navigator.resume();
      }
      else if (verb == 4)
      {
        if (model == S::NAV_ERROR) model = S::IDLE;
        navigator.resetNavError();
      }
      else
      {
        if (model == S::NAVIGATING)
        {
          starts += start_due;
          start_due = false;
          expected_commands = !arrives;
          errors += fails;
          ends += arrives;
          if (fails) model = S::NAV_ERROR;
          if (arrives) model = S::IDLE;
        }
        robot.obeys = !fails;
        const auto at = robot.state.pose;
        robot.advance(0.05);
        if (arrives) robot.state.pose.x = 1e4;
        navigator.navigationStep();
        if (arrives) robot.state.pose = at;
        robot.obeys = true;
      }
      ASSERT_EQ(current(), model);
      ASSERT_EQ(robot.commands - commands, expected_commands);
      ASSERT_TRUE(model == S::NAVIGATING || robot.flown.isStopCmd());
    }
    step();
    starts += model == S::NAVIGATING && start_due;
    EXPECT_EQ(robot.count("start"), starts);
    EXPECT_EQ(robot.count("end"), ends);
    EXPECT_EQ(robot.count("error end"), errors);
    EXPECT_GT(ends, 0);
    EXPECT_GT(errors, 0);
  }
}

TEST_F(StateMachine, VerbsFromCallbacksWinOverTheStep)
{
  using S = CAbstractNavigator::TState;
  struct Case
  {
    std::function<void()> verb;
    S expected;
  };
  const std::vector<Case> cases = {{[this] { navigator.cancel(); }, S::IDLE},
                                   {[this] { navigator.suspend(); }, S::SUSPENDED}};
  for (const Case& c : cases)
    for (std::function<void()>* hook : {&robot.during_command, &robot.during_query})
    {
      navigator.cancel();
      navigate(goalAt({100, 0, 0}));
      step();
      *hook = c.verb;
      step();
      *hook = nullptr;
      EXPECT_EQ(current(), c.expected);
      EXPECT_TRUE(robot.flown.isStopCmd());
      EXPECT_FALSE(leaves(c.expected, 5));
    }
}

TEST_F(StateMachine, TheNextGoalMayBeGivenInTheEndEvent)
{
  int laps = 3;
  robot.during_event = [&](const std::string& what)
  {
    if (what == "end" && --laps > 0) navigate(goalAt({0, 0, laps % 2 ? 0.0 : 5.0}));
  };
  navigate(goalAt({0, 0, 5}));
  for (int i = 0; i < 600 && laps > 0; ++i) step();
  step();
  EXPECT_EQ(current(), CAbstractNavigator::IDLE);
  EXPECT_EQ(robot.count("start"), 3);
  EXPECT_EQ(robot.count("end"), 3);
  EXPECT_EQ(robot.count("watchdog on"), 3);
}

TEST_F(StateMachine, AGoalChangedInFlightIsNoNewNavigation)
{
  navigate(goalAt({5, 0, 0}));
  for (int i = 0; i < 10; ++i) step();
  navigate(goalAt({0, 0, 5}));
  ASSERT_TRUE(leaves(CAbstractNavigator::NAVIGATING));
  EXPECT_LT(robot.distanceTo({0, 0, 5}), 0.5);
  EXPECT_EQ(robot.count("start"), 1);
  EXPECT_EQ(robot.count("end"), 1);
}

TEST_F(StateMachine, ALoopIsNotOverBeforeItsWaypoints)
{
  navigate(goalAt({0, 0, 0}, {{3, 0, 0}, {3, 0, 3}}));
  ASSERT_TRUE(leaves(CAbstractNavigator::NAVIGATING));
  EXPECT_EQ(current(), CAbstractNavigator::IDLE);
  EXPECT_EQ(robot.count("waypoint 0"), 1);
  EXPECT_EQ(robot.count("waypoint 1"), 1);
  EXPECT_GT(robot.t, 7.0) << "the loop is about 10 m at 1 m/s";
}

TEST_F(StateMachine, AGoalBetweenTwoStepsIsReached)
{
  navigator.speed_mps = 5.0;
  navigator.disturb_command = [](auto& r) { r.command = {5, 0, 0, 0}; };
  NavigationParams3D goal = goalAt({3.75, 0.05, 0.05});
  goal.allowed_distance_m = 0.1;
  navigate(goal);
  for (int i = 0; i < 5 && current() == CAbstractNavigator::NAVIGATING; ++i) step(0.5);
  EXPECT_EQ(current(), CAbstractNavigator::IDLE);
}

TEST_F(StateMachine, TheEarlyEndEventIsThreeDimensional)
{
  navigator.params_abstract_navigator.dist_to_target_for_sending_event = 2.0;
  navigate(goalAt({0, 0, 10}));
  while (robot.count("end") == 0 && current() == CAbstractNavigator::NAVIGATING) step();
  EXPECT_NEAR(robot.distanceTo({0, 0, 10}), 2.0, 0.06);
  EXPECT_EQ(current(), CAbstractNavigator::NAVIGATING);
  ASSERT_TRUE(leaves(CAbstractNavigator::NAVIGATING));
  EXPECT_EQ(robot.count("end"), 1);
  EXPECT_EQ(navigator.params_abstract_navigator.dist_to_target_for_sending_event, 2.0);
}

TEST_F(StateMachine, EveryStepSensesAtAnyRate)
{
  navigate(goalAt({100, 0, 0}));
  for (int i = 0; i < 50; ++i) step(0.001);
  EXPECT_EQ(robot.state_queries, 50);
  EXPECT_EQ(robot.commands, 50);
  EXPECT_EQ(navigator.senses, 50);
  EXPECT_EQ(navigator.idles, 0);
  navigator.suspend();
  for (int i = 0; i < 50; ++i) step(0.001);
  EXPECT_EQ(navigator.senses, 100);
  EXPECT_EQ(navigator.idles, 50);
  EXPECT_EQ(robot.commands, 50);
}

TEST_F(StateMachine, WaitsForAStateWithoutFailing)
{
  navigator.params_abstract_navigator.alarm_seems_not_approaching_target_timeout = 1.0;
  navigator.disturb_query = [] { return test::StraightNavigator::StateQuery::NotYet; };
  navigate(goalAt({0, 0, 0}));  // where an unknown state would be taken for the origin
  for (int i = 0; i < 100; ++i) step();
  EXPECT_EQ(current(), CAbstractNavigator::NAVIGATING);
  EXPECT_TRUE(robot.flown.isStopCmd());
  EXPECT_EQ(robot.count("WAITING_FOR_STATE"), 1);
  robot.state.pose.x = 3.0;
  navigator.disturb_query = nullptr;
  ASSERT_TRUE(leaves(CAbstractNavigator::NAVIGATING));
  EXPECT_EQ(current(), CAbstractNavigator::IDLE);
  EXPECT_EQ(robot.count("NAVIGATING"), 1);
  EXPECT_EQ(robot.count("start"), 1);
}

TEST_F(StateMachine, ABlockedGoalIsTheHostsDecision)
{
  navigate(goalAt({5, 0, 0}));
  step();
  navigator.disturb_command = [](auto& r)
  { r.status = Status::GoalBlocked, r.command = {}, r.detail = "wall"; };
  for (int i = 0; i < 5; ++i) step();
  EXPECT_EQ(current(), CAbstractNavigator::NAVIGATING);
  EXPECT_EQ(robot.count("GOAL_BLOCKED"), 1);
  EXPECT_EQ(robot.count("target blocked"), 1);
  EXPECT_EQ(robot.details.back(), "GOAL_BLOCKED: wall");

  navigator.disturb_command = nullptr;
  step();
  robot.during_event = [this](const std::string& what)
  {
    if (what == "GOAL_BLOCKED") navigator.cancel();
  };
  navigator.disturb_command = [](auto& r) { r.status = Status::GoalBlocked; };
  step();
  EXPECT_EQ(current(), CAbstractNavigator::IDLE);
}

TEST_F(StateMachine, RefusesBadGoalsAndGoesOn)
{
  navigate(goalAt({5, 0, 0}));
  step();
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto complaint = [this](const CAbstractNavigator::TNavigationParams* params)
  {
    try
    {
      navigator.navigate(params);
    }
    catch (const std::invalid_argument& e)
    {
      return std::string(e.what());
    }
    return std::string("accepted");
  };
  const auto bad = [&](const std::function<void(NavigationParams3D&)>& spoil)
  {
    NavigationParams3D goal = goalAt({0, 0, 5}, {{1, 1, 1}});
    spoil(goal);
    return complaint(&goal);
  };
  const auto says = [](const std::string& text, const std::string& part)
  { return text.find(part) != std::string::npos; };
  const CAbstractNavigator::TNavigationParams planar;
  EXPECT_TRUE(says(complaint(&planar), "NavigationParams3D"));
  EXPECT_TRUE(says(complaint(nullptr), "NavigationParams3D"));
  EXPECT_TRUE(says(bad([](auto& g) { g.target.targetIsRelative = true; }), "relative"));
  EXPECT_TRUE(says(bad([nan](auto& g) { g.target3D.z = nan; }), "target is not finite"));
  EXPECT_TRUE(says(bad([nan](auto& g) { g.waypoints[0].y = nan; }), "waypoint 0"));
  EXPECT_TRUE(says(bad([](auto& g) { g.allowed_distance_m = 0.0; }), "allowed_distance_m = 0"));
  EXPECT_EQ(current(), CAbstractNavigator::NAVIGATING);
  ASSERT_TRUE(leaves(CAbstractNavigator::NAVIGATING));
  EXPECT_LT(robot.distanceTo({5, 0, 0}), 0.5);
  EXPECT_EQ(navigator.goals, 1);

  test::StraightNavigator fresh(robot);
  const NavigationParams3D goal = goalAt({1, 1, 1});
  EXPECT_THROW(fresh.navigate(&goal), std::logic_error);
}

TEST(Navigator, LoadsMrptsOwnSection)
{
  test::MockRobot3D robot;
  test::StraightNavigator navigator(robot);
  mrpt::config::CConfigFileMemory config;
  config.write("CAbstractNavigator", "alarm_seems_not_approaching_target_timeout", 7.0);
  config.write("straight", "speed_mps", 2.0);
  navigator.loadConfigFile(config);
  EXPECT_EQ(navigator.params_abstract_navigator.alarm_seems_not_approaching_target_timeout, 7.0);
  EXPECT_EQ(navigator.speed_mps, 2.0);
}

TEST(Navigator, IsSilent)
{
  testing::internal::CaptureStdout();
  testing::internal::CaptureStderr();
  {
    test::MockRobot3D robot;
    test::StraightNavigator navigator(robot);
    navigator.loadConfigFile(mrpt::config::CConfigFileMemory());
    navigator.initialize();
    const NavigationParams3D goal = goalAt({1, 1, 1});
    navigator.navigate(&goal);
    while (navigator.getCurrentState() == CAbstractNavigator::NAVIGATING)
    {
      robot.advance(0.05);
      navigator.navigationStep();
    }
    navigator.navigationStep();
  }
  EXPECT_EQ(testing::internal::GetCapturedStdout(), "");
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

}  // namespace
}  // namespace slalom::navigator
