// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "slalom/core/CycleRecord.h"
#include "slalom/core/Measurements.h"
#include "slalom/engine/EngineConfig.h"
#include "slalom/engine/Mission.h"
#include "slalom/engine/StepHooks.h"

namespace slalom::engine
{
enum class EngineStatus
{
  WaitingForState,  ///< the estimator is not aligned yet
  NoMission,        ///< mapping only
  Navigating,
  GoalReached,  ///< within the tolerance; latched until the next mission
  GoalBlocked,  ///< holds at the reachable point nearest to a goal that is occupied or cut off;
                ///< leaves when plans have led to the goal again for two seconds
  Unreachable,  ///< at rest in mid-mission for longer than mission.blocked_timeout_s, or no farther
                ///< on R for mission.progress_timeout_s; leaves when it moves again
  SensorLost    ///< a sensor that the mission is flown by has been silent, or too slow, for longer
                ///< than mission.sensor_timeout_s; leaves when it is heard again
};
[[nodiscard]] std::string_view toString(EngineStatus status);

/// Counters for metrics.json.
struct EngineStatistics
{
  std::uint64_t cycles = 0, scans = 0, map_updates = 0, replans = 0;
  std::uint64_t refined_ok = 0, refined_failed = 0, recoveries = 0;
  std::uint64_t fallback_shifted = 0, fallback_brake = 0;
  std::uint64_t late_map = 0, late_global = 0, late_local = 0;  ///< steps longer than their period
  std::map<std::string, std::uint64_t> gate;  ///< commands that the output gate changed, by reason
  std::uint64_t safe_stops = 0;               ///< SAFE_STOP events
  std::uint64_t safe_recoveries = 0;          ///< RECOVER events
  std::map<std::string, std::uint64_t> dropped;  ///< measurements not used, by reason
  std::string state_source;                      ///< the source in use
};

/** The tracker: measurements in, velocity commands out [Paper Algorithm 1].
 *
 *    engine.setMission(mission);
 *    for (...) { engine.add(measurement); ...; CycleRecord cycle = engine.step(now);
 * use(cycle.command); }
 *
 *  observation -> state + rays -> map snapshot -> refined reference -> plan -> gate -> command; one
 * direction. Calls come from one thread. step() never throws: what goes wrong is in the record's
 * status and reason, and the command is then a brake. CycleRecord::events tells what has changed:
 * SAFE_STOP, RECOVER, and every new status but NO_MISSION by its name. */
class Engine
{
 public:
  /// @throws mrpt_io::ConfigError if the configuration contradicts itself
  explicit Engine(const EngineConfig& config, StepHooks hooks = {});
  ~Engine();

  /** Starts a mission at the vehicle's position; replaces the previous one. One that is too long
   * only from there is refused by step(), with the reason in its record.
   *  @throws std::invalid_argument if check() does */
  void setMission(const Mission& mission);
  void clearMission();

  /// Takes a measurement, in order of arrival.
  void add(const core::Measurement& measurement);

  /** One cycle at log time t [s]: maps what has arrived, refines R if due, and plans.
   *  @param drive false: perception only, the command is "stand still" (suspended or idle host) */
  [[nodiscard]] core::CycleRecord step(double t, bool drive = true);

  [[nodiscard]] EngineStatus status() const;
  [[nodiscard]] std::optional<core::VehicleState> state() const;
  [[nodiscard]] const EngineStatistics& statistics() const;
  /// Length of R [m]; 0 without a mission.
  [[nodiscard]] double referenceLength() const;

  /// Writes the octree of record as .bt; waits for a running map step. False when there is nothing
  /// to write or no way to.
  [[nodiscard]] bool writeOctree(const std::filesystem::path& file);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace slalom::engine
