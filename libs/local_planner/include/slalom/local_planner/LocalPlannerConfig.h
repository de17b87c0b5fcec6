// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "slalom/core/Fields.h"
#include "slalom/optim/TrackingQp.h"

namespace slalom::local_planner
{
/// The NMPC [Paper Eq. (9)]. INI section [local_planner].
struct LocalPlannerConfig
{
  int horizon = 25;                 ///< [1] N_p, stages
  double step_s = 0.1;              ///< [s] delta_tc
  double weight_position = 4.0;     ///< Q, across the reference
  double weight_lag = 2.0;          ///< Q, along it: a delayed vehicle need not cut corners
  double weight_yaw = 1.0;          ///< Q, yaw
  double weight_velocity = 3.0;     ///< Q, velocity against the spline's
  double weight_command = 1.0;      ///< R, command against the one that keeps the spline's velocity
  double weight_yaw_rate = 0.1;     ///< R, yaw rate against the reference's
  double weight_rate = 3.0;         ///< S, change of the command against the reference's
  double obstacle_penalty = 200.0;  ///< exact (L1), per metre, row and stage; has to outweigh the
                                    ///< pull of the reference
  int obstacles_per_stage = 4;      ///< [1] nearest obstacle points kept per stage (C_o)
  double min_clearance_margin_m =
      0.1;                          ///< [m] obstacle distance asked for beyond the vehicle's radius
  double mover_margin_m = 0.3;      ///< [m] likewise of what moves
  double yaw_hold_speed_mps = 0.2;  ///< [m/s] below this the heading reference holds
  optim::TrackingBackEnd solver = optim::TrackingBackEnd::Riccati;
  double tolerance = 1e-6;
  int max_iterations = 40;

  template <class Self, class Visit>
  static void fields(Self& c, Visit&& v)
  {
    using core::Level;
    using core::Range;
    using B = optim::TrackingBackEnd;
    v("horizon", c.horizon, Range{2, 100}, "stages of the NMPC");
    v("step_s", c.step_s, Range{0.01, 1.0}, "time between stages");
    v("weight_position", c.weight_position, Range{0.0, 1e5},
      "on the distance to the refined reference, across it");
    v("weight_lag", c.weight_lag, Range{0.0, 1e5}, "on the distance along it");
    v("weight_yaw", c.weight_yaw, Range{0.0, 1e5}, "on the heading error");
    v("weight_velocity", c.weight_velocity, Range{0.0, 1e5},
      "on the velocity's difference to the reference's");
    v("weight_command", c.weight_command, Range{0.0, 1e5},
      "on the command's difference to the one that keeps the reference's velocity");
    v("weight_yaw_rate", c.weight_yaw_rate, Range{0.0, 1e5},
      "on the difference to the yaw rate of the reference");
    v("weight_rate", c.weight_rate, Range{0.0, 1e5},
      "on the change of the command between stages, as far as the reference does not ask for it");
    v("obstacle_penalty", c.obstacle_penalty, Range{0.1, 1e6},
      "per metre and stage of violated obstacle distance", Level::Expert);
    v("obstacles_per_stage", c.obstacles_per_stage, Range{0, 20},
      "nearest obstacle points per stage", Level::Expert);
    v("min_clearance_margin_m", c.min_clearance_margin_m, Range{0.0, 5.0},
      "obstacle distance asked for beyond the vehicle's radius");
    v("mover_margin_m", c.mover_margin_m, Range{0.0, 5.0},
      "distance to moving obstacles asked for beyond both radii");
    v("yaw_hold_speed_mps", c.yaw_hold_speed_mps, Range{0.0, 5.0},
      "slower than this the heading holds", Level::Expert);
    v("solver", c.solver, core::Names<B>{{"riccati", B::Riccati}, {"ipopt", B::Ipopt}},
      "riccati: our real-time solver; ipopt: the reference it is checked against");
    v("tolerance", c.tolerance, Range{1e-9, 1e-1}, "of the NMPC solver", Level::Expert);
    v("max_iterations", c.max_iterations, Range{1, 3000}, "of the NMPC solver", Level::Expert);
  }
};

}  // namespace slalom::local_planner
