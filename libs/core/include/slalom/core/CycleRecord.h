// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "slalom/core/DistanceField.h"
#include "slalom/core/HalfSpaces.h"
#include "slalom/core/MovingObstacle.h"
#include "slalom/core/SolveReport.h"
#include "slalom/core/VehicleState.h"

namespace slalom::core
{
using Polyline = Eigen::Matrix3Xd;  ///< one point per column [m], local frame L

/// A pull on one control point: from `from_L` on the obstacle's side to `to_L` on the pushing path
/// S_*.
struct PushArrow
{
  Eigen::Vector3d from_L = Eigen::Vector3d::Zero();
  Eigen::Vector3d to_L = Eigen::Vector3d::Zero();
};

/// How the global planner arrived at the refined reference [Paper Algorithm 1].
struct RefinementRecord
{
  bool ran = false;  ///< false: this cycle had no global step, the rest is from the last one
  std::string
      outcome;  ///< one of the planner's outcome names, e.g. "Refined", "Clear", "GuideFailed"
  std::string reason;  ///< one line: what was done and why
  std::vector<Polyline>
      occupied_segments;                ///< stretches of R that collide or come closer than allowed
  std::vector<Polyline> guides;         ///< searched detours
  std::vector<Polyline> pushing_paths;  ///< S_* [Paper Eq. (2)]
  std::vector<HalfSpaces> polyhedra;    ///< of the convex decomposition
  std::vector<PushArrow> directions;    ///< gradient vectors [Paper Algorithm 2]
  SolveReport solve;                    ///< of J [Paper Eq. (1)]
  double min_clearance_m = 0.0;         ///< of the refined window, optimistic field, sampled
  bool certified = false;               ///< the whole plan is proved clear
  double certificate_margin_m = 0.0;    ///< proved clearance beyond the vehicle's radius
  double stop_excess = 0.0;             ///< [1] to rest where the plan ends takes this much more
                                        ///< acceleration than planned with; 0 normally
  std::string goal;                     ///< what the map says of the goal, e.g. "free"
  double goal_short_m = 0.0;            ///< the plan ends this far from the goal, 0 if at it
};

/// What the output gate did to the command, and what it knows of the way to stop.
struct GateRecord
{
  std::string intervention;    ///< empty, or why the command is not the one that was wanted
  double stop_margin_m = 0.0;  ///< clearance beyond the radius of the stop that is still possible
};

/// News of a cycle, e.g. SAFE_STOP: a change of what the vehicle does, with one line of why.
struct Event
{
  std::string name, detail;
};

/// Wall time of each part of a cycle [s]; 0 where the part did not run.
struct CycleTiming
{
  double estimate = 0.0, map = 0.0, edt = 0.0, global = 0.0, local = 0.0, cycle = 0.0;
};

/** Everything one engine cycle knew, wanted and commanded. Plain values: reports draw it, logs keep
 * it, nothing in it leads back into the engine. */
struct CycleRecord
{
  std::uint64_t index = 0;
  double t = 0.0;          ///< [s] log time
  bool has_state = false;  ///< false: nothing is known of the vehicle yet, `state` is a default
  VehicleState state;
  std::shared_ptr<const DistanceField> field;  ///< may be null before the first scan
  double origin_offset_norm_m = 0.0;           ///< |W - L| offset, for the record

  Polyline reference;  ///< immutable R, local frame, sampled over its whole length; empty without a
                       ///< mission
  Polyline refined;    ///< refined reference over the planning window
  Polyline committed;  ///< its beginning, up to where the vehicle rests if no better plan comes
  Polyline horizon;    ///< NMPC prediction, N+1 points; empty when no local plan
  Eigen::VectorXd horizon_yaw;                                  ///< [rad] N+1
  Eigen::Vector3d reference_point_L = Eigen::Vector3d::Zero();  ///< R at the current progress
  Eigen::Vector3d refined_point_L =
      Eigen::Vector3d::Zero();  ///< refined reference at the current progress
  Eigen::Vector3d setpoint_L = Eigen::Vector3d::Zero();  ///< first predicted state of the NMPC
  double setpoint_yaw = 0.0;
  double progress_s = 0.0;  ///< [s] parameter on R
  double pace = 1.0;        ///< [1] how fast the parameter runs, 1 = real time
  double distance_to_goal_m = 0.0;
  RefinementRecord refinement;
  SolveReport nmpc;
  std::vector<MovingObstacle> movers;  ///< tracked now
  VelocityCommand command;
  GateRecord gate;
  std::vector<Event> events;
  bool verified_stop = true;  ///< at rest, or on a plan that can rest where it ends
  std::string status;         ///< engine state, e.g. NAVIGATING, GOAL_REACHED
  std::string fallback;  ///< empty, or the rung of the fallback ladder that produced the command
  std::string reason;    ///< one line: why this command
  CycleTiming timing;
  std::uint64_t map_sequence = 0, reference_sequence = 0;
  std::uint64_t decision_hash = 0;  ///< running hash over every decision so far
};

}  // namespace slalom::core
