// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/obs/CObservation.h>

#include <string>
#include <utility>
#include <vector>

#include "slalom/navigator/Navigator.h"

namespace slalom::replay
{
/// The vehicle of a recording: it senses what was recorded and flies what was flown, whatever it is
/// told.
class ReplayRobot final : public navigator::RobotInterface3D
{
 public:
  ReplayRobot() { setMinLoggingLevel(mrpt::system::LVL_ERROR); }

  void deliver(mrpt::obs::CObservation::Ptr observation)
  {
    waiting_.push_back(std::move(observation));
  }
  void setTime(const mrpt::Clock::time_point& now) { now_ = now; }

  [[nodiscard]] const std::string& lastEvent() const { return last_event_; }
  [[nodiscard]] const std::string& lastEventDetail() const { return last_detail_; }

  // The state follows from the observations.
  bool getCurrentState3D(navigator::State3D&) override { return false; }
  bool changeSpeeds3D(const navigator::VelocityCommand3D&) override { return true; }
  bool stop3D(bool) override { return true; }
  bool pullObservations(std::vector<mrpt::obs::CObservation::Ptr>& observations) override
  {
    std::move(waiting_.begin(), waiting_.end(), std::back_inserter(observations));
    waiting_.clear();
    return true;
  }
  mrpt::Clock::time_point now() override { return now_; }
  double getNavigationTime() override { return mrpt::Clock::toDouble(now_); }
  void onEvent(const std::string& name, const std::string& detail) override
  {
    last_event_ = name;
    last_detail_ = detail;
  }

 private:
  std::vector<mrpt::obs::CObservation::Ptr> waiting_;
  mrpt::Clock::time_point now_;
  std::string last_event_, last_detail_;
};

}  // namespace slalom::replay
