// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "slalom/core/Fields.h"
#include "slalom/simulation/Shapes.h"

namespace slalom::simulation
{
/// INI section [forest].
struct ForestConfig
{
  double size_m = 40.0;          ///< [m] edge of the square around the origin
  double density_per_m2 = 0.15;  ///< [1/m^2] trees
  double min_radius_m = 0.2;     ///< [m]
  double max_radius_m = 0.45;    ///< [m]
  double min_height_m = 5.0;     ///< [m]
  double max_height_m = 10.0;    ///< [m]
  double min_gap_m = 0.4;        ///< [m] between the surfaces of two trunks
  double clear_m = 1.5;          ///< [m] around (-size/2 + 1, 0) and (size/2 - 1, 0)

  template <class Self, class Visit>
  static void fields(Self& c, Visit&& v)
  {
    using core::Range;
    v("size_m", c.size_m, Range{4.0, 1000.0}, "edge of the square around the origin");
    v("density_per_m2", c.density_per_m2, Range{0.0, 2.0}, "trees per square metre");
    v("min_radius_m", c.min_radius_m, Range{0.01, 5.0}, "thinnest trunk");
    v("max_radius_m", c.max_radius_m, Range{0.01, 5.0}, "thickest trunk");
    v("min_height_m", c.min_height_m, Range{0.1, 100.0}, "lowest tree");
    v("max_height_m", c.max_height_m, Range{0.1, 100.0}, "highest tree");
    v("min_gap_m", c.min_gap_m, Range{-10.0, 10.0}, "least gap between two trunks");
    v("clear_m", c.clear_m, Range{0.0, 100.0}, "free space around both ends of the x axis");
  }
};

/** Trees uniform over a square, trunk by trunk, those that would stand too near to another thrown
 * again.
 *  @throws std::invalid_argument on an inverted range, or if the density cannot be reached with the
 * gaps asked for */
[[nodiscard]] std::vector<Tree> makeForest(const ForestConfig& config, std::uint64_t seed);

/// A forest, and the shortest way through it.
struct SolvableForest
{
  std::vector<Tree> trees;
  double shortest_m = 0.0;  ///< [m] between the clear places at both ends of the x axis
  int rejected = 0;         ///< forests without a way that were thrown away
};

/** The first of a row of forests, the same for the same seed, through which a ball finds its way at
 * 1.5 m of height without leaving the square (the first one is makeForest(config, seed)).
 *  @param radius [m] of the ball
 *  @throws std::invalid_argument as makeForest(), or if there is none in 50 */
[[nodiscard]] SolvableForest makeSolvableForest(const ForestConfig& config, std::uint64_t seed,
                                                double radius);

/// The csv that World::load reads, to 0.1 mm.
[[nodiscard]] std::string forestCsv(const std::vector<Tree>& trees);

}  // namespace slalom::simulation
