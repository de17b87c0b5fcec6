// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "slalom/core/Fields.h"
#include "slalom/optim/BoxMinimizer.h"

namespace slalom::global_planner
{
/// What a committed plan makes of space that was never seen.
enum class UnknownPolicy
{
  Avoid,  ///< the vehicle always can stop in known free space
  Free    ///< unknown space is free until it is seen not to be
};

/// What to do when the end of R turns out to be occupied or cannot be reached.
enum class GoalPolicy
{
  Approach,     ///< go as near as possible and hold: GOAL_BLOCKED
  NearestFree,  ///< the same, but within goal_radius_m of the goal it counts as reached
  Reject        ///< an occupied goal ends the mission where the vehicle is
};

/// Where a vehicle that had to leave R comes back to it.
enum class ReturnPolicy
{
  Auto,  ///< Late if the mission is a single goal, so that nobody asked for R itself; else Soon
  Soon,  ///< behind what was in the way
  Late   ///< by the shortest way to where the refined window of R ends
};

/// Which form of Eq. (2) finds the pushing path.
enum class PushingForm
{
  Qp,   ///< squares: unique, evenly spaced, keeps clearance_m where the gap permits
  Socp  ///< the paper's norms: the taut string inside hard clearance
};

/// Weights and limits of the refinement [Paper Eq. (1)-(8)]. INI section [global_planner].
struct GlobalPlannerConfig
{
  double clearance_m = 0.8;  ///< [m] D_z, Eq. (4): kept where the gap permits
  double horizon_m = 8.0;    ///< [m] window of R that is refined, along R
  double lambda_smooth = 0.2, lambda_obs = 0.6, lambda_feas = 0.2;  ///< [1] Eq. (1)
  double lambda_fit = 0.1;              ///< [1] pull back to R (deviation D-07)
  double guide_proximity_weight = 2.0;  ///< [1] how much the guide prefers wide gaps
  double guide_unknown_weight = 1.0;    ///< [1] how much it prefers space that was seen
  PushingForm pushing = PushingForm::Qp;
  double piece_m = 1.5;  ///< [m] longest piece of the convex decomposition
  double box_lateral_m = 2.0, box_along_m = 1.0, box_vertical_m = 2.0;  ///< [m] local box
  double max_offset_m = 8.0;  ///< [m] box constraint: control points stay this near to R
  double max_climb_m = 0.2;   ///< [m] box constraint: never farther above or below R than this
  double min_altitude_m = 0.3, max_altitude_m = 50.0;  ///< [m] box constraint in z, world frame
  double restart_distance_m =
      1.0;                 ///< [m] farther from its plan than this the vehicle gets a new start
  double margin_m = 0.05;  ///< [m] plans are proved to keep the vehicle's radius and this
  double tight_speed_mps = 0.4;  ///< [m/s] speed allowed where nothing is left to the sides ...
  double reaction_s =
      0.3;  ///< [s] ... and more by what is left per this: tracking error over speed
  UnknownPolicy unknown = UnknownPolicy::Avoid;
  ReturnPolicy return_to_reference = ReturnPolicy::Auto;
  GoalPolicy goal_policy = GoalPolicy::Approach;
  double goal_radius_m = 1.0;                             ///< [m] GoalPolicy::NearestFree
  optim::BoxMethod optimizer = optim::BoxMethod::Newton;  ///< of J
  int max_evaluations = 150;                              ///< [1] evaluations of J per attempt
  int max_attempts = 3;  ///< [1] restarts with a stronger lambda_obs
  int threads = 1;       ///< [1] for the parallel decomposition

  template <class Self, class Visit>
  static void fields(Self& c, Visit&& v)
  {
    using core::Level;
    using core::Range;
    v("clearance_m", c.clearance_m, Range{0.05, 5.0},
      "D_z: free distance kept where the gap permits");
    v("horizon_m", c.horizon_m, Range{1.0, 100.0},
      "length of reference refined ahead of the vehicle");
    v("lambda_smooth", c.lambda_smooth, Range{0.0, 1e4}, "weight of smoothness in J");
    v("lambda_obs", c.lambda_obs, Range{0.0, 1e4}, "weight of obstacle distance in J");
    v("lambda_feas", c.lambda_feas, Range{0.0, 1e4},
      "weight of speed and acceleration limits in J");
    v("lambda_fit", c.lambda_fit, Range{0.0, 1e4}, "weight of staying near the reference in J");
    v("guide_proximity_weight", c.guide_proximity_weight, Range{0.0, 100.0},
      "how much the guide prefers wide gaps over short ways", Level::Expert);
    v("guide_unknown_weight", c.guide_unknown_weight, Range{0.0, 100.0},
      "how much the guide prefers space that was seen; at most guide_proximity_weight counts",
      Level::Expert);
    v("pushing", c.pushing,
      core::Names<PushingForm>{{"qp", PushingForm::Qp}, {"socp", PushingForm::Socp}},
      "form of the pushing program: squares, or the paper's norms", Level::Expert);
    v("piece_m", c.piece_m, Range{0.2, 5.0}, "longest piece of the convex decomposition",
      Level::Expert);
    v("box_lateral_m", c.box_lateral_m, Range{0.5, 10.0}, "local box of a piece, to both sides",
      Level::Expert);
    v("box_along_m", c.box_along_m, Range{0.1, 10.0}, "local box of a piece, beyond its ends",
      Level::Expert);
    v("box_vertical_m", c.box_vertical_m, Range{0.5, 10.0}, "local box of a piece, up and down",
      Level::Expert);
    v("max_offset_m", c.max_offset_m, Range{0.5, 100.0},
      "farthest a control point may leave the reference", Level::Expert);
    v("max_climb_m", c.max_climb_m, Range{0.0, 100.0},
      "a detour stays this near to the reference's altitude: a lidar does not see what is above");
    v("min_altitude_m", c.min_altitude_m, Range{-1000.0, 10000.0},
      "lowest altitude of the reference");
    v("max_altitude_m", c.max_altitude_m, Range{-1000.0, 10000.0},
      "highest altitude of the reference");
    v("restart_distance_m", c.restart_distance_m, Range{0.1, 100.0},
      "farther from its plan than this, the plan starts anew at the vehicle");
    v("margin_m", c.margin_m, Range{0.0, 5.0},
      "a plan is proved to keep the vehicle's radius and this from every obstacle");
    v("tight_speed_mps", c.tight_speed_mps, Range{0.05, 100.0},
      "speed allowed where the vehicle just fits");
    v("reaction_s", c.reaction_s, Range{0.01, 10.0},
      "where x metres are left beside the vehicle it flies x / reaction_s faster than that");
    v("unknown", c.unknown,
      core::Names<UnknownPolicy>{{"avoid", UnknownPolicy::Avoid}, {"free", UnknownPolicy::Free}},
      "avoid: always able to stop in space that was seen free; free: only seen obstacles count");
    v("return_to_reference", c.return_to_reference,
      core::Names<ReturnPolicy>{
          {"auto", ReturnPolicy::Auto}, {"soon", ReturnPolicy::Soon}, {"late", ReturnPolicy::Late}},
      "where to come back after a detour: soon behind the obstacle, late by the shortest way "
      "to the end of the horizon; auto: late if the mission is a single goal");
    v("goal_policy", c.goal_policy,
      core::Names<GoalPolicy>{{"approach_and_hold", GoalPolicy::Approach},
                              {"nearest_free", GoalPolicy::NearestFree},
                              {"reject", GoalPolicy::Reject}},
      "what to do when the goal is occupied or cannot be reached");
    v("goal_radius_m", c.goal_radius_m, Range{0.0, 100.0},
      "nearest_free: within this of the goal the nearest free point counts as reached");
    v("optimizer", c.optimizer,
      core::Names<optim::BoxMethod>{{"newton", optim::BoxMethod::Newton},
                                    {"lbfgs", optim::BoxMethod::Lbfgs}},
      "what minimises J: a banded second-order method, or the paper's L-BFGS (slower)",
      Level::Expert);
    v("max_evaluations", c.max_evaluations, Range{1, 10000}, "cost evaluations of J per attempt",
      Level::Expert);
    v("max_attempts", c.max_attempts, Range{1, 10},
      "attempts with four times the obstacle weight each", Level::Expert);
    v("threads", c.threads, Range{1, 64}, "threads of the convex decomposition", Level::Expert);
  }
};

}  // namespace slalom::global_planner
