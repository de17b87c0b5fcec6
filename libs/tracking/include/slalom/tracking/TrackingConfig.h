// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "slalom/core/Fields.h"

namespace slalom::tracking
{
/// INI section [tracking].
struct TrackingConfig
{
  bool enabled = true;
  double range_m = 8.0;       ///< [m] returns up to here are looked at
  double min_range_m = 0.5;   ///< [m] nearer returns are the vehicle itself
  double cell_m = 0.35;       ///< [m] returns in neighbouring cells belong to one object
  double max_extent_m = 2.5;  ///< [m] larger things, in the plane or in height, are structure
  double min_height_m = 0.2;  ///< [m] flatter things are ground
  int min_points = 8;         ///< [1] fewer returns are no object

  double min_speed_mps = 0.25;      ///< [m/s] slower things are left to the map
  double min_displacement_m = 0.3;  ///< [m] what has not come this far is not said to move
  double significance = 3.0;        ///< [1] displacement over its standard deviation
  double evidence = 0.5;  ///< [1] share of the returns that lie where there was nothing, plus share
                          ///< of the former returns where there is nothing any more
  int evidence_scans = 4;           ///< [1] so many scans must say so
  double free_margin_m = 0.15;      ///< [m] a ray must have gone on this far beyond a point ...
  double free_width_m = 0.12;       ///< [m] ... and its neighbours this near, too
  double coast_s = 1.0;             ///< [s] a mover that is not seen any more is given up
  double sigma_position_m = 0.05;   ///< [m] of a measured centre in the plane
  double sigma_acceleration = 0.4;  ///< [m/s^2] that a mover shows, per axis
  double radius_margin_m = 0.1;     ///< [m] added to the seen half extent
  double ghost_margin_m = 0.2;      ///< [m] map cells this near a former footprint are cleared

  template <class Self, class Visit>
  static void fields(Self& c, Visit&& v)
  {
    using core::Level;
    using core::Range;
    v("enabled", c.enabled, "track what moves, keep it out of the map, and predict it");
    v("range_m", c.range_m, Range{2.0, 30.0}, "moving things are looked for up to this range");
    v("min_range_m", c.min_range_m, Range{0.0, 5.0},
      "returns nearer than this are the vehicle itself");
    v("min_speed_mps", c.min_speed_mps, Range{0.1, 5.0},
      "what moves slower than this is left to the map");
    v("coast_s", c.coast_s, Range{0.1, 5.0}, "a mover unseen for this long is given up");
    v("radius_margin_m", c.radius_margin_m, Range{0.0, 1.0}, "added to the seen size of a mover");
    v("cell_m", c.cell_m, Range{0.1, 1.0}, "returns in neighbouring cells are one object",
      Level::Expert);
    v("max_extent_m", c.max_extent_m, Range{0.5, 10.0}, "larger things are structure",
      Level::Expert);
    v("min_height_m", c.min_height_m, Range{0.0, 1.0}, "flatter things are ground", Level::Expert);
    v("min_points", c.min_points, Range{3, 1000}, "fewer returns are no object", Level::Expert);
    v("min_displacement_m", c.min_displacement_m, Range{0.2, 5.0},
      "what has not come this far is not said to move", Level::Expert);
    v("significance", c.significance, Range{1.0, 10.0},
      "a mover's displacement in standard deviations, at least", Level::Expert);
    v("evidence", c.evidence, Range{0.2, 2.0},
      "returns where nothing was, plus former returns where nothing is, as shares", Level::Expert);
    v("evidence_scans", c.evidence_scans, Range{1, 20}, "scans in favour that confirm a mover",
      Level::Expert);
    v("free_margin_m", c.free_margin_m, Range{0.05, 1.0},
      "a ray shows a point free if it went on this far beyond", Level::Expert);
    v("free_width_m", c.free_width_m, Range{0.05, 1.0}, "and so did all rays that passed this near",
      Level::Expert);
    v("sigma_position_m", c.sigma_position_m, Range{0.01, 0.5},
      "standard deviation of a measured centre", Level::Expert);
    v("sigma_acceleration", c.sigma_acceleration, Range{0.05, 10.0},
      "standard deviation of a mover's acceleration", Level::Expert);
    v("ghost_margin_m", c.ghost_margin_m, Range{0.0, 1.0},
      "map cells this near a mover's former footprint are cleared", Level::Expert);
  }
};

}  // namespace slalom::tracking
