// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>

#include "slalom/mapping/MapperConfig.h"

namespace slalom::mapping::detail
{
/// The sensor model of a config as log-odds, in the single precision of OctoMap's nodes.
struct LogOddsModel
{
  float hit, miss, clamp_min, clamp_max, occupied;

  explicit LogOddsModel(const MapperConfig& c)
      : hit(of(c.hit)),
        miss(of(c.miss)),
        clamp_min(of(c.clamp_min)),
        clamp_max(of(c.clamp_max)),
        occupied(of(c.occupied_threshold))
  {
  }
  [[nodiscard]] static float of(double p) { return static_cast<float>(std::log(p / (1.0 - p))); }
};

}  // namespace slalom::mapping::detail
