// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "DecisionHash.h"
#include "Flight.h"
#include "FlightEvents.h"
#include "MissionJudge.h"
#include "MotionPredictor.h"
#include "Pipeline.h"
#include "Plausibility.h"
#include "ReferenceClock.h"
#include "Refinements.h"
#include "ScanAssembler.h"
#include "SensorWatch.h"
#include "StateSource.h"
#include "Stopwatch.h"
#include "slalom/engine/Engine.h"
#include "slalom/local_planner/LocalPlanner.h"
#include "slalom/safety/OutputGate.h"

namespace slalom::engine
{
/** One cycle goes through run(): state -> map -> refined reference -> plan, and what it decides
 * leaves through release(): gate -> command.
 *
 *  A command takes effect vehicle.command_delay_s after it was decided. Plans, the clock and both
 *  planners live at that later time: they are handed the state predicted for it. */
struct Engine::Impl
{
  Impl(const EngineConfig& c, StepHooks h)
      : config(c),
        hooks(std::move(h)),
        source(c.state, c.estimation),
        scans(c.mapping),
        pipeline(c, hooks),
        refinements(c.rates.global_period_s),
        local(c.local_planner, c.vehicle),
        clock(c.mission.max_lead_s, c.rates.open_loop),
        judge(config),
        sensors(config),
        predictor(c.vehicle),
        gate(c.guarded(), c.vehicle)
  {
  }

  /// What a cycle knows from its beginning.
  struct Cycle
  {
    core::CycleRecord& record;
    double dt;   ///< [s] since the last cycle
    bool drive;  ///< the vehicle is allowed to move
    const Stopwatch& watch;
    core::VehicleState ahead{};  ///< when the command takes effect
    std::string unsafe{};        ///< why safety makes the vehicle brake; empty: it does not
    bool waiting = false;        ///< the vehicle cannot begin yet
  };

  /// @name Map (Perception.cpp)
  /// @{
  [[nodiscard]] std::shared_ptr<const MapResult> currentMap() const;
  void beginNewFrame();
  void mapPending(double t);
  /// @}

  /// @name Mission and refined reference (Guidance.cpp)
  /// @{
  [[nodiscard]] std::string startMission(const core::VehicleState& state);
  void followDrift(const core::VehicleState& state, double dt);
  void requestRefinement(const core::VehicleState& state, double t);
  void takeRefinement(core::CycleRecord& record);
  [[nodiscard]] double onReference() const;
  /// @}

  /// @name Gate, command (Release.cpp)
  /// @{
  [[nodiscard]] safety::StopPath plannedStop() const;
  void ageReliedStop(double dt);
  void release(Cycle& cycle, const core::VelocityCommand& wanted);
  /// @}

  /// @name Cycle, plan (Engine.cpp)
  /// @{
  [[nodiscard]] core::VelocityCommand run(Cycle& cycle);
  void giveUpWithoutSensors(Cycle& cycle);
  [[nodiscard]] core::VelocityCommand plan(Cycle& cycle);
  [[nodiscard]] std::string doubt(const core::CycleRecord& record) const;
  [[nodiscard]] core::Deadline localDeadline(const Cycle& cycle) const;
  [[nodiscard]] Eigen::Vector3d pointDue(double t, const Eigen::Vector3d& point_of_effect_L);
  [[nodiscard]] core::VelocityCommand stop(Cycle& cycle, std::string reason);
  [[nodiscard]] double sinceLastCommand(const Cycle& cycle) const;
  void describe(core::CycleRecord& record) const;
  void finish(const Cycle& cycle);
  /// @}

  EngineConfig config;
  StepHooks hooks;
  StateSource source;
  ScanAssembler scans;
  Pipeline pipeline;
  Refinements refinements;
  local_planner::LocalPlanner local;
  ReferenceClock clock;
  MissionJudge judge;
  SensorWatch sensors;
  std::string scan_label;  // of the newest scan
  MotionPredictor predictor;
  safety::OutputGate gate;
  safety::Evasion relied_evasion;  // likewise, the way aside
  safety::StopPath relied_stop;  // the plan by which the vehicle could stop after its last command
  std::deque<std::pair<double, Eigen::Vector3d>>
      due;  // points of the plan, by their time of effect
  StandstillWatch standstill;
  FlightEvents events;
  EngineStatistics statistics;
  EngineStatus status = EngineStatus::WaitingForState;

  std::optional<Mission> waiting_mission;
  std::optional<Flight> flight;
  std::uint64_t missions = 0;

  std::uint64_t seen_epoch = 0;
  bool scan_refused = false;    // the newest scan contradicted the map
  std::uint64_t map_frame = 0;  // maps of any other frame are void
  std::uint64_t seen_map = 0;
  std::optional<double> last_t;
  core::VelocityCommand last_command;
  DecisionHash hash;
  double estimate_s = 0.0;  // wall time of add() since the last cycle
};

}  // namespace slalom::engine
