// SPDX-License-Identifier: BSD-3-Clause
#include "slalom/simulation/Forest.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <stdexcept>

#include "slalom/core/Rng.h"
#include "slalom/simulation/ShortestPath.h"

namespace slalom::simulation
{
std::vector<Tree> makeForest(const ForestConfig& config, std::uint64_t seed)
{
  if (config.min_radius_m > config.max_radius_m || config.min_height_m > config.max_height_m)
    throw std::invalid_argument("forest: a least radius or height above the greatest");
  constexpr int kTries = 2000;  // per tree
  core::Rng rng(seed);
  const double half = 0.5 * config.size_m;
  const Eigen::Vector2d end(half - 1.0, 0.0);
  const auto wanted =
      static_cast<std::size_t>(std::lround(config.density_per_m2 * config.size_m * config.size_m));
  std::vector<Tree> trees;
  const auto fits = [&](const Tree& tree)
  {
    for (const Eigen::Vector2d& clear : {end, Eigen::Vector2d(-end)})
      if ((tree.centre_W - clear).norm() < config.clear_m + tree.radius) return false;
    return std::all_of(trees.begin(), trees.end(),
                       [&](const Tree& other)
                       {
                         return (tree.centre_W - other.centre_W).norm() >=
                                tree.radius + other.radius + config.min_gap_m;
                       });
  };
  while (trees.size() < wanted)
  {
    Tree tree;
    tree.radius = rng.uniform(config.min_radius_m, config.max_radius_m);
    tree.height = rng.uniform(config.min_height_m, config.max_height_m);
    int tries = 0;
    do {
      if (++tries > kTries)
        throw std::invalid_argument("forest: no room for tree " + std::to_string(trees.size() + 1) +
                                    " of " + std::to_string(wanted));
      tree.centre_W = {rng.uniform(-half, half), 0.0};
      tree.centre_W.y() = rng.uniform(-half, half);
    } while (!fits(tree));
    trees.push_back(tree);
  }
  return trees;
}

namespace
{
/// So that nobody goes around the forest.
World fenced(const std::vector<Tree>& trees, double half)
{
  const auto wall = [](const Eigen::Vector2d& a, const Eigen::Vector2d& b)
  { return Box(Eigen::Vector3d(a.x(), a.y(), 0.0), Eigen::Vector3d(b.x(), b.y(), 100.0)); };
  const double out = half + 1.0;
  return World::of(trees,
                   {wall({-out, -out}, {out, -half}), wall({-out, half}, {out, out}),
                    wall({-out, -out}, {-half, out}), wall({half, -out}, {out, out})},
                   true);
}
}  // namespace

SolvableForest makeSolvableForest(const ForestConfig& config, std::uint64_t seed, double radius)
{
  constexpr int kForests = 50;
  constexpr double kHeight = 1.5;  // [m]
  core::Rng seeds(seed);
  const Eigen::Vector3d end(0.5 * config.size_m - 1.0, 0.0, 0.0), up(0.0, 0.0, kHeight);
  for (int rejected = 0; rejected < kForests; ++rejected)
  {
    SolvableForest forest{makeForest(config, rejected == 0 ? seed : seeds.bits()), 0.0, rejected};
    const auto shortest = shortestPath(fenced(forest.trees, 0.5 * config.size_m + radius), up - end,
                                       up + end, radius);
    if (!shortest) continue;
    forest.shortest_m = *shortest;
    return forest;
  }
  throw std::invalid_argument("forest: no way for a radius of " + std::to_string(radius) +
                              " m in " + std::to_string(kForests) + " forests");
}

std::string forestCsv(const std::vector<Tree>& trees)
{
  std::string csv = "x,y,radius,height\n";
  char line[128];
  for (const Tree& tree : trees)
  {
    std::snprintf(line, sizeof(line), "%.4f,%.4f,%.4f,%.4f\n", tree.centre_W.x(), tree.centre_W.y(),
                  tree.radius, tree.height);
    csv += line;
  }
  return csv;
}

}  // namespace slalom::simulation
