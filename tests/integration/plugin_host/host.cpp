// SPDX-License-Identifier: BSD-3-Clause
// plugin_host MODULE CLASS [CONFIG.ini]: loads a navigator plugin and drives a mock vehicle through
// every state. Prints one line per broken expectation; exit code 0 if there is none.
#include <mrpt/config/CConfigFile.h>
#include <mrpt/config/CConfigFileMemory.h>
#include <mrpt/io/CMemoryStream.h>
#include <mrpt/serialization/CArchive.h>

#include <iostream>

#include "MockRobot3D.h"
#include "slalom/navigator/Navigator.h"

namespace
{
using slalom::navigator::NavigationParams3D;
using slalom::navigator::NavigatorFactory;
using slalom::navigator::VelocityCommand3D;
using Navigator = slalom::navigator::AbstractNavigator3D;
using mrpt::math::TPoint3D;

int broken = 0;
void expect(bool holds, const std::string& what)
{
  if (holds) return;
  ++broken;
  std::cerr << "BROKEN: " << what << "\n";
}
void expectError(const std::string& part, const std::function<void()>& action)
{
  std::string text = "(no error)";
  try
  {
    action();
  }
  catch (const std::exception& e)
  {
    text = e.what();
  }
  expect(text.find(part) != std::string::npos, "an error with '" + part + "', got: " + text);
}

class Flight
{
 public:
  explicit Flight(std::unique_ptr<Navigator> navigator, slalom::test::MockRobot3D& robot)
      : robot_(robot), navigator_(std::move(navigator))
  {
  }
  void navigate(const TPoint3D& to, std::vector<TPoint3D> waypoints = {})
  {
    NavigationParams3D goal;
    goal.target3D = {to.x, to.y, to.z, 0, 0, 0};
    goal.waypoints = std::move(waypoints);
    navigator_->navigate(&goal);
  }
  void steps(int n)
  {
    for (int i = 0; i < n; ++i)
    {
      robot_.advance(0.05);
      navigator_->navigationStep();
    }
  }
  /// Steps while NAVIGATING, at most `seconds`.
  void fly(double seconds)
  {
    for (const double end = robot_.t + seconds;
         robot_.t < end && navigator_->getCurrentState() == Navigator::NAVIGATING;)
      steps(1);
  }
  void expectState(Navigator::TState state, const std::string& when)
  {
    const std::string got = std::to_string(navigator_->getCurrentState());
    expect(navigator_->getCurrentState() == state,
           "state " + std::to_string(state) + " " + when + ", got " + got);
  }
  Navigator& operator*() { return *navigator_; }
  Navigator* operator->() { return navigator_.get(); }

 private:
  slalom::test::MockRobot3D& robot_;
  std::unique_ptr<Navigator> navigator_;
};

void suspendResumeArrive(Flight& flight, slalom::test::MockRobot3D& robot)
{
  flight.expectState(Navigator::IDLE, "at first");
  flight.steps(3);
  expect(robot.commands == 0, "no command in IDLE");
  flight.navigate({4, 0, 2});
  flight.steps(10);
  flight.expectState(Navigator::NAVIGATING, "after navigate()");
  flight->suspend();
  flight.steps(5);
  flight.expectState(Navigator::SUSPENDED, "after suspend()");
  expect(robot.flown.isStopCmd(), "a suspended vehicle stands still");
  flight->resume();
  flight.expectState(Navigator::NAVIGATING, "after resume()");
  flight.fly(60.0);
  flight.expectState(Navigator::IDLE, "at the goal");
  expect(robot.distanceTo({4, 0, 2}) < 0.6, "arrives at the goal");
  expect(robot.flown.isStopCmd(), "stands still at the goal");
  expect(robot.count("start") == 1 && robot.count("end") == 1, "one start and one end event");
}

void sequenceOfGoals(Flight& flight, slalom::test::MockRobot3D& robot)
{
  robot.log.clear();
  flight.navigate({4, 0, 6});
  flight.steps(1);
  flight.expectState(Navigator::NAVIGATING, "below a goal that is straight above");
  flight.fly(60.0);
  expect(robot.distanceTo({4, 0, 6}) < 0.6, "climbs to the goal above");
  flight.navigate({0, 0, 3}, {{2, 2, 4}});
  flight.fly(60.0);
  flight.expectState(Navigator::IDLE, "after two goals");
  expect(robot.distanceTo({0, 0, 3}) < 0.6, "arrives at the second goal");
  expect(robot.count("start") == 2 && robot.count("end") == 2, "two start and two end events");
}

void cancelAndErrors(Flight& flight, slalom::test::MockRobot3D& robot)
{
  flight.navigate({20, 0, 3});
  flight.steps(10);
  flight->cancel();
  flight.expectState(Navigator::IDLE, "after cancel()");
  expect(robot.flown.isStopCmd(), "a cancelled vehicle stands still");

  robot.log.clear();
  flight->logging_enable_console_output = false;
  flight.navigate({20, 0, 3});
  flight.steps(10);
  robot.obeys = false;
  flight.steps(1);
  robot.obeys = true;
  const int commands = robot.commands;
  flight.steps(20);
  flight.expectState(Navigator::NAV_ERROR, "after a refused command");
  expect(robot.commands == commands, "no command in NAV_ERROR");
  expect(!flight->getErrorReason().error_msg.empty(), "NAV_ERROR has a reason");
  expect(robot.count("error end") == 1, "one error event");
  const TPoint3D here = robot.state.pose.translation();
  flight.navigate({here.x, here.y + 3.0, here.z});
  flight.fly(60.0);
  flight.expectState(Navigator::IDLE, "NAV_ERROR is left by a new goal, which is reached");

  const mrpt::nav::CAbstractNavigator::TNavigationParams planar;
  expectError("NavigationParams3D", [&] { flight->navigate(&planar); });
  NavigationParams3D relative;
  relative.target.targetIsRelative = true;
  expectError("relative", [&] { flight->navigate(&relative); });
  flight.expectState(Navigator::IDLE, "after refused goals");
}

void commandsTravelByName()
{
  mrpt::io::CMemoryStream stream;
  auto archive = mrpt::serialization::archiveFrom(stream);
  archive << VelocityCommand3D(1, 2, 3, 4);
  stream.Seek(0);
  const auto object = archive.ReadObject();
  const auto command = std::dynamic_pointer_cast<VelocityCommand3D>(object);
  expect(command && command->vz == 3.0 && command->wz == 4.0, "commands travel by class name");
}

void run(const std::string& module, const std::string& class_name, const char* config_file)
{
  expectError("not found", [] { NavigatorFactory::loadModule("/no/such/place/navigator.so"); });
  NavigatorFactory::loadModule(module);
  expectError("available: ", [] { (void)NavigatorFactory::named("NoSuchFactory"); });
  expectError("not a navigator factory",
              [] { (void)NavigatorFactory::named("VelocityCommand3D"); });

  slalom::test::MockRobot3D robot;
  robot.state.pose.z = 2.0;
  const NavigatorFactory::Ptr factory = NavigatorFactory::named(class_name);
  Flight flight(factory->create(robot), robot);
  if (config_file)
    flight->loadConfigFile(mrpt::config::CConfigFile(config_file));
  else
    flight->loadConfigFile(mrpt::config::CConfigFileMemory());
  flight->initialize();
  suspendResumeArrive(flight, robot);
  sequenceOfGoals(flight, robot);
  cancelAndErrors(flight, robot);
  commandsTravelByName();
}

}  // namespace

int main(int argc, char** argv)
{
  if (argc < 3) return 2;
  try
  {
    run(argv[1], argv[2], argc > 3 ? argv[3] : nullptr);
  }
  catch (const std::exception& e)
  {
    expect(false, e.what());
  }
  return broken == 0 ? 0 : 1;
}
