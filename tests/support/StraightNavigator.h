// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <stdexcept>

#include "slalom/navigator/Navigator.h"

namespace slalom::test
{
/// The simplest navigator: flies straight through the waypoints to the goal. A script can disturb
/// it.
class StraightNavigator : public navigator::AbstractNavigator3D
{
 public:
  using navigator::AbstractNavigator3D::AbstractNavigator3D;
  using navigator::AbstractNavigator3D::StateQuery;
  using navigator::AbstractNavigator3D::StepResult;

  double speed_mps = 1.0;
  int senses = 0, idles = 0, goals = 0, ends = 0;
  std::function<void(StepResult&)> disturb_command;
  std::function<void()> disturb_sense;
  std::function<StateQuery()> disturb_query;

  void loadConfigFile(const mrpt::config::CConfigFileBase& config) override
  {
    speed_mps = config.read_double("straight", "speed_mps", speed_mps);
    if (!(speed_mps > 0.0 && speed_mps < 30.0))
      throw std::runtime_error("[straight] speed_mps must be in (0, 30)");
    AbstractNavigator3D::loadConfigFile(config);
  }

 protected:
  void goalAccepted(const navigator::NavigationParams3D&) override
  {
    ++goals;
    next_ = 0;
  }
  void goalEnded() override { ++ends; }
  void sense(double) override
  {
    ++senses;
    if (disturb_sense) disturb_sense();
  }
  void idle(double) override { ++idles; }
  StateQuery queryState(navigator::State3D& state) override
  {
    return disturb_query ? disturb_query() : AbstractNavigator3D::queryState(state);
  }
  StepResult computeCommand(double, const navigator::State3D* state,
                            const navigator::NavigationParams3D& goal) override
  {
    StepResult result;
    if (state)
      steer(result.command, state->pose.translation(), goal);
    else
      result.status = StepResult::Status::WaitingForState;
    if (disturb_command) disturb_command(result);
    return result;
  }

 private:
  void steer(navigator::VelocityCommand3D& command, const mrpt::math::TPoint3D& here,
             const navigator::NavigationParams3D& goal)
  {
    while (next_ < goal.waypoints.size() &&
           (goal.waypoints[next_] - here).norm() < 0.5 * goal.allowed_distance_m)
      ++next_;
    const mrpt::math::TPoint3D to =
        (next_ < goal.waypoints.size() ? goal.waypoints[next_] : goal.target3D.translation()) -
        here;
    const double scale = speed_mps / std::max(to.norm(), speed_mps);
    command = {to.x * scale, to.y * scale, to.z * scale, 0.0};
  }
  std::size_t next_ = 0;
};

}  // namespace slalom::test
