// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "HostSettings.h"
#include "slalom/core/CycleRecord.h"
#include "slalom/engine/Mission.h"
#include "slalom/navigator/Navigator.h"
#include "slalom/report/FlightReport.h"

namespace slalom::app
{
/// Waypoints of a file, not more than can be flown. @throws mrpt_io::ConfigError
[[nodiscard]] engine::Mission readMission(const std::filesystem::path& file,
                                          const engine::EngineConfig& config);

/** The host of a navigator plugin, as slalom-replay and slalom-fly are: loads it, steps it in the
 * time of the vehicle, and writes the report of what it did.
 *
 *    FlightHost host(settings, plugin, robot, out);
 *    host.open(describe);  host.navigate(mission);
 *    for (...) host.step(now);
 *    host.finish(summary); */
class FlightHost
{
 public:
  /// Everything must outlive it.
  FlightHost(const HostSettings& settings, const PluginConfig& plugin,
             navigator::RobotInterface3D& robot, std::filesystem::path out);
  ~FlightHost();

  /** Loads and initialises the navigator, and makes MRPT's clock a simulated one.
   *  @param describe adds what only the program knows of the run, when the report is opened */
  void open(std::function<void(report::RunInfo&)> describe);
  void navigate(const engine::Mission& mission);
  /// One navigationStep() at this Unix time [s]. @throws report::OutputError
  void step(double now);

  [[nodiscard]] navigator::AbstractNavigator3D& navigator() { return *navigator_; }
  [[nodiscard]] bool hasReport() const { return report_ != nullptr; }
  [[nodiscard]] const std::string& status() const { return status_; }        ///< of the last cycle
  [[nodiscard]] bool goalReached() const { return goal_reached_; }           ///< in any cycle
  [[nodiscard]] double distanceToGoal() const { return distance_to_goal_; }  ///< [m] last known

  /// What the navigator can tell of the input, for the program to add to.
  [[nodiscard]] report::InputSummary inputSummary() const;
  /// Without a cycle there is no report yet: opens it, so that the outcome is written all the same.
  void ensureReport();
  /// The map, if there is one to keep, and the rest of the report. @throws report::OutputError
  void finish(const report::RunSummary& summary, bool with_map);

 private:
  void onCycle(const core::CycleRecord& cycle);
  void onTruth(double t, const mrpt::math::TPose3D& pose);

  const HostSettings& settings_;
  const PluginConfig& plugin_;
  navigator::RobotInterface3D& robot_;
  std::filesystem::path out_;
  std::function<void(report::RunInfo&)> describe_;
  std::unique_ptr<navigator::AbstractNavigator3D> navigator_;
  std::unique_ptr<report::FlightReport> report_;
  std::vector<core::TimedPose> early_truth_;  // before the first cycle opens the report
  std::string status_;
  double distance_to_goal_ = 0.0;
  bool goal_reached_ = false;
};

/// Makes the output folder ready. @throws UsageError
void prepareFolder(const std::filesystem::path& folder, bool overwrite);

}  // namespace slalom::app
