// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/obs/CObservation.h>

#include <iterator>
#include <utility>
#include <vector>

#include "slalom/navigator/Navigator.h"

namespace slalom::app
{
/// A vehicle that hands on the observations it is given, and lives in a time that it is told.
class ObservationRobot : public navigator::RobotInterface3D
{
 public:
  ObservationRobot() { setMinLoggingLevel(mrpt::system::LVL_ERROR); }

  void deliver(mrpt::obs::CObservation::Ptr observation)
  {
    waiting_.push_back(std::move(observation));
  }
  void setTime(const mrpt::Clock::time_point& now) { now_ = now; }

  // The state follows from the observations.
  bool getCurrentState3D(navigator::State3D&) override { return false; }
  bool pullObservations(std::vector<mrpt::obs::CObservation::Ptr>& observations) override
  {
    std::move(waiting_.begin(), waiting_.end(), std::back_inserter(observations));
    waiting_.clear();
    return true;
  }
  mrpt::Clock::time_point now() override { return now_; }
  double getNavigationTime() override { return mrpt::Clock::toDouble(now_); }

 private:
  std::vector<mrpt::obs::CObservation::Ptr> waiting_;
  mrpt::Clock::time_point now_;
};

}  // namespace slalom::app
