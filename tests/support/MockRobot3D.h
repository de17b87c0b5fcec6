// SPDX-License-Identifier: BSD-3-Clause
/** A vehicle that does what it is told, in simulated time, and writes down what happened to it.
 * Includes MRPT and the navigator's public header only. */
#pragma once

#include <algorithm>
#include <functional>
#include <string>
#include <vector>

#include "slalom/navigator/Navigator.h"

namespace slalom::test
{
class MockRobot3D : public navigator::RobotInterface3D
{
 public:
  navigator::State3D state;
  navigator::VelocityCommand3D flown;
  double t = 0.0;
  std::vector<std::string> log;      ///< events and stops, in order
  std::vector<std::string> details;  ///< "NAME: detail" of every onEvent()
  int commands = 0, state_queries = 0;
  bool tells_state = true, obeys = true, jammed = false;
  std::function<void()> during_command, during_query;
  std::function<void(const std::string&)> during_event;  ///< may call verbs

  MockRobot3D()
  {
    setMinLoggingLevel(mrpt::system::LVL_ERROR);
    advance(0.0);
    mrpt::Clock::setActiveClock(mrpt::Clock::Simulated);
  }
  ~MockRobot3D() override { mrpt::Clock::setActiveClock(mrpt::Clock::Realtime); }

  /// Flies the last command for dt seconds.
  void advance(double dt)
  {
    t += dt;
    if (!jammed)
    {
      state.pose.x += flown.vx * dt;
      state.pose.y += flown.vy * dt;
      state.pose.z += flown.vz * dt;
      state.pose.yaw += flown.wz * dt;
    }
    state.twist = {flown.vx, flown.vy, flown.vz, 0.0, 0.0, flown.wz};
    state.time = mrpt::Clock::fromDouble(1.6e9 + t);
    mrpt::Clock::setSimulatedTime(state.time);
  }
  [[nodiscard]] double distanceTo(const mrpt::math::TPoint3D& point) const
  {
    return (state.pose.translation() - point).norm();
  }
  [[nodiscard]] long count(const std::string& what) const
  {
    return std::count(log.begin(), log.end(), what);
  }

  bool getCurrentState3D(navigator::State3D& out) override
  {
    ++state_queries;
    if (during_query) during_query();
    out = state;
    return tells_state;
  }
  bool changeSpeeds3D(const navigator::VelocityCommand3D& command) override
  {
    ++commands;
    if (obeys) flown = command;
    if (during_command) during_command();
    return obeys;
  }
  bool stop3D(bool emergency) override
  {
    flown.setToStop();
    log.emplace_back(emergency ? "emergency stop" : "stop");
    return true;
  }
  double getNavigationTime() override { return t; }
  bool startWatchdog(float) override { return say("watchdog on"); }
  bool stopWatchdog() override { return say("watchdog off"); }
  void onEvent(const std::string& name, const std::string& detail) override
  {
    details.push_back(name + ": " + detail);
    happen(name);
  }
  void sendNavigationStartEvent() override { happen("start"); }
  void sendNavigationEndEvent() override { happen("end"); }
  void sendNavigationEndDueToErrorEvent() override { happen("error end"); }
  void sendWaySeemsBlockedEvent() override { happen("way blocked"); }
  void sendCannotGetCloserToBlockedTargetEvent() override { happen("target blocked"); }
  void sendWaypointReachedEvent(int index, bool) override
  {
    happen("waypoint " + std::to_string(index));
  }

 private:
  bool say(const std::string& what)
  {
    log.push_back(what);
    return true;
  }
  void happen(const std::string& what)
  {
    log.push_back(what);
    if (during_event) during_event(what);
  }
};

}  // namespace slalom::test
