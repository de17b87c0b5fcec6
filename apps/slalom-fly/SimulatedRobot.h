// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "ObservationRobot.h"
#include "slalom/core/VehicleState.h"

namespace slalom::fly
{
/// News of the navigator and its step.
struct HeardEvent
{
  double unix_time = 0.0;  ///< [s]
  std::string name, detail;
};

/// The simulated vehicle as the navigator sees it: it remembers the last command for the simulation
/// to fly, and what the navigator says.
class SimulatedRobot final : public app::ObservationRobot
{
 public:
  [[nodiscard]] const core::VelocityCommand& command() const { return command_; }
  [[nodiscard]] bool navigationEnded() const { return ended_; }
  [[nodiscard]] bool navigationFailed() const { return failed_; }
  [[nodiscard]] const std::string& lastDetail() const { return last_detail_; }
  [[nodiscard]] std::vector<HeardEvent> takeEvents() { return std::exchange(events_, {}); }

  /// True state, for navigators that ask the vehicle instead of its sensors. Without it: not told.
  void setState(const navigator::State3D& state) { state_ = state; }

  bool getCurrentState3D(navigator::State3D& state) override
  {
    if (state_) state = *state_;
    return state_.has_value();
  }
  bool changeSpeeds3D(const navigator::VelocityCommand3D& c) override
  {
    const core::VelocityCommand command{{c.vx, c.vy, c.vz}, c.wz};
    if (!command.v_W.allFinite() || !std::isfinite(command.yaw_rate)) return false;
    command_ = command;
    return true;
  }
  bool stop3D(bool) override
  {
    command_ = {};
    return true;
  }
  void onEvent(const std::string& name, const std::string& detail) override
  {
    last_detail_ = detail;
    events_.push_back({getNavigationTime(), name, detail});
  }
  void sendNavigationEndEvent() override { ended_ = true; }
  void sendNavigationEndDueToErrorEvent() override { failed_ = true; }

 private:
  std::optional<navigator::State3D> state_;
  core::VelocityCommand command_;
  bool ended_ = false, failed_ = false;
  std::string last_detail_;
  std::vector<HeardEvent> events_;
};

}  // namespace slalom::fly
