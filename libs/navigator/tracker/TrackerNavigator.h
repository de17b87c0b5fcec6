// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "HostSenses.h"
#include "TrackerConfig.h"
#include "slalom/core/CycleRecord.h"
#include "slalom/engine/Engine.h"
#include "slalom/navigator/Navigator.h"

namespace slalom::navigator
{
/** The engine behind MRPT's navigator door: observations in, engine cycles, commands out. One
 * engine cycle per navigationStep() in every state; only NAVIGATING drives. */
class TrackerNavigator : public AbstractNavigator3D
{
 public:
  explicit TrackerNavigator(RobotInterface3D& robot);
  ~TrackerNavigator() override;

  void loadConfigFile(const mrpt::config::CConfigFileBase& source) override;
  void saveConfigFile(mrpt::config::CConfigFileBase& target) const override;
  void initialize() override;
  void navigationStep() override;

  void setCycleListener(CycleListener listener) override { on_cycle_ = std::move(listener); }
  void setTruthListener(TruthListener listener) override { on_truth_ = std::move(listener); }
  [[nodiscard]] std::string effectiveConfig() const override { return config_.effective; }
  [[nodiscard]] std::string runStatisticsJson() const override;
  [[nodiscard]] bool writeMap(const std::string& file) override;

 protected:
  void sense(double t) override;
  void idle(double t) override;
  StepResult computeCommand(double t, const State3D* state,
                            const NavigationParams3D& goal) override;
  StateQuery queryState(State3D& state) override;
  void goalAccepted(const NavigationParams3D& goal) override;
  void goalEnded() override;
  [[nodiscard]] bool reachedTarget(const State3D&, const NavigationParams3D&) const override;
  [[nodiscard]] double remainingDistance(const State3D&, const NavigationParams3D&) const override;

 private:
  /// One engine cycle; null while time has not begun.
  const core::CycleRecord* cycle(bool drive);
  void tellListeners();
  void tellHost(const std::vector<core::Event>& events);

  TrackerConfig config_;
  std::unique_ptr<HostSenses> senses_;
  std::unique_ptr<engine::Engine> engine_;
  std::optional<core::CycleRecord> record_;  // of the current step
  double distance_to_goal_m_ = 0.0;
  CycleListener on_cycle_;
  TruthListener on_truth_;
};

/// Name of the plugin's door: slalom::navigator::TrackerNavigatorFactory.
class TrackerNavigatorFactory : public NavigatorFactory
{
  DEFINE_MRPT_OBJECT(TrackerNavigatorFactory, slalom::navigator)

 public:
  [[nodiscard]] std::unique_ptr<AbstractNavigator3D> create(RobotInterface3D& robot) const override;
};

}  // namespace slalom::navigator
