// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "slalom/core/Fields.h"

namespace slalom::mapping
{
/// What a firing without an echo says.
enum class NoReturn
{
  Free,    ///< that nothing is there, as far as is fused
  Unknown  ///< nothing
};

/// INI section [mapping].
struct MapperConfig
{
  double resolution_m = 0.2;    ///< [m] voxel edge
  double update_range_m = 6.0;  ///< [m] rays are fused up to here; longer ones clear space only
  double min_range_m = 0.4;     ///< [m] nearer returns are the vehicle itself
  NoReturn no_return = NoReturn::Free;  ///< an open field has no echoes to show that it is open
  double window_xy_m = 16.0;            ///< [m] edge of the rolling window, >= 2 update_range_m
  double window_z_m = 8.0;              ///< [m] height of the rolling window
  double max_distance_m = 3.0;          ///< [m] saturation of the distance transform
  double hit = 0.7, miss = 0.45;        ///< [1] sensor model, probabilities
  double clamp_min = 0.12, clamp_max = 0.97;  ///< [1] log-odds clamps, as probabilities
  double occupied_threshold = 0.5;  ///< [1] probability at and above which a cell is an obstacle
  double forget_s = 0.0;      ///< [s] cells unseen for this long return to unknown; 0 keeps them
  double start_ball_m = 2.0;  ///< [m] ball around the first pose assumed free where unknown
  double bridge_m = 0.2;  ///< [m] unknown space this near above or below space seen free counts as
                          ///< free: a lidar of few rings leaves gaps, and sees little near itself
  bool keep_octree = true;       ///< write changed cells to the OctoMap of record
  double max_octree_mb = 200.0;  ///< [MB] the octree is cropped around the vehicle beyond this

  template <class Self, class Visit>
  static void fields(Self& c, Visit&& v)
  {
    using core::Level;
    using core::Range;
    v("resolution_m", c.resolution_m, Range{0.05, 1.0},
      "voxel edge; 0.2 is fast, 0.1 resolves thin branches");
    v("update_range_m", c.update_range_m, Range{1.0, 50.0}, "returns up to this range become map");
    v("min_range_m", c.min_range_m, Range{0.0, 5.0},
      "returns nearer than this are the vehicle itself");
    v("no_return", c.no_return,
      core::Names<NoReturn>{{"free", NoReturn::Free}, {"unknown", NoReturn::Unknown}},
      "what a firing without an echo says of the space from 1 m in front of the sensor on");
    v("window_xy_m", c.window_xy_m, Range{4.0, 100.0},
      "edge of the window that moves with the vehicle");
    v("window_z_m", c.window_z_m, Range{2.0, 50.0}, "height of that window");
    v("max_distance_m", c.max_distance_m, Range{0.5, 15.0}, "distances saturate here",
      Level::Expert);
    v("hit", c.hit, Range{0.5, 0.99}, "probability given to a cell by one return", Level::Expert);
    v("miss", c.miss, Range{0.01, 0.5}, "probability given to a cell by one ray through it",
      Level::Expert);
    v("clamp_min", c.clamp_min, Range{0.001, 0.5}, "lower clamp of a cell's probability",
      Level::Expert);
    v("clamp_max", c.clamp_max, Range{0.5, 0.999}, "upper clamp of a cell's probability",
      Level::Expert);
    v("occupied_threshold", c.occupied_threshold, Range{0.1, 0.95},
      "probability from which a cell is an obstacle", Level::Expert);
    v("forget_s", c.forget_s, Range{0.0, 3600.0},
      "cells unseen for this long return to unknown, 0 = never");
    v("start_ball_m", c.start_ball_m, Range{0.0, 5.0},
      "unknown space this near to the first pose counts as free");
    v("bridge_m", c.bridge_m, Range{0.0, 2.0},
      "unknown space this near above or below space seen free counts as free");
    v("keep_octree", c.keep_octree, "keep the OctoMap of the whole flight (map.bt)");
    v("max_octree_mb", c.max_octree_mb, Range{1.0, 10000.0}, "memory bound of that OctoMap",
      Level::Expert);
  }
};

}  // namespace slalom::mapping
