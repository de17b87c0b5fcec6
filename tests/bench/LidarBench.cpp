// SPDX-License-Identifier: BSD-3-Clause
/** Rays of a VLP-16 through a forest of 40 x 40 m: trees as cylinders and as an octree of 0.1 m
 * voxels, OctoMap's castRay on the same octree, and whole scans with poses, noise and packets. */
#include <benchmark/benchmark.h>
#include <octomap/octomap.h>

#include <cmath>
#include <filesystem>

#include "slalom/core/Rng.h"
#include "slalom/simulation/Forest.h"
#include "slalom/simulation/Vlp16Model.h"
#include "slalom/simulation/World.h"

namespace
{
using Eigen::Vector3d;
using namespace slalom::simulation;

constexpr double kRange = 100.0;

std::vector<Tree> forest()
{
  return makeForest({}, 1);
}

octomap::OcTree voxelForest()
{
  octomap::OcTree tree(0.1);
  for (const Tree& trunk : forest())
    for (double z = 0.05; z < trunk.height; z += 0.1)
      for (double a = 0.0; a < 6.2832; a += 0.05)
        tree.updateNode(trunk.centre_W.x() + trunk.radius * std::cos(a),
                        trunk.centre_W.y() + trunk.radius * std::sin(a), z, true, true);
  tree.updateInnerOccupancy();
  return tree;
}

struct Rays
{
  std::vector<Vector3d> origins, directions;
  explicit Rays(const World& world)
  {
    slalom::core::Rng rng(7);
    while (origins.size() < 4096)
    {
      const Vector3d p(rng.uniform(-19.0, 19.0), rng.uniform(-19.0, 19.0), rng.uniform(1.0, 2.5));
      if (world.distance(p) < 0.4) continue;
      const double start = rng.uniform(-3.1416, 3.1416);
      for (int k = 0; k < 256; ++k)  // 16 firings in a row
      {
        const double az = start + 3.5e-3 * (k / 16);
        const double el = slalom::mrpt_io::kVlp16Elevation[k % 16] * 3.14159265 / 180.0;
        origins.push_back(p);
        directions.emplace_back(std::cos(el) * std::cos(az), std::cos(el) * std::sin(az),
                                std::sin(el));
      }
    }
  }
};

void castAll(benchmark::State& state, const World& world)
{
  const Rays rays(world);
  for (auto _ : state)
    for (std::size_t k = 0; k < rays.origins.size(); ++k)
      benchmark::DoNotOptimize(world.castRay(rays.origins[k], rays.directions[k], kRange));
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(rays.origins.size()));
}

void Cylinders(benchmark::State& state)
{
  castAll(state, World::of(forest(), {}, true));
}
BENCHMARK(Cylinders)->Unit(benchmark::kMillisecond);

World octreeWorld()
{
  const std::filesystem::path file =
      std::filesystem::temp_directory_path() / "slalom_bench_lidar.bt";
  octomap::OcTree tree = voxelForest();
  tree.writeBinary(file.string());
  World world = World::load(file);
  std::filesystem::remove(file);
  return world;
}

void Octree(benchmark::State& state)
{
  castAll(state, octreeWorld());
}
BENCHMARK(Octree)->Unit(benchmark::kMillisecond);

void OctomapCastRay(benchmark::State& state)
{
  const octomap::OcTree tree = voxelForest();
  const Rays rays(World::of(forest(), {}, false));
  const auto point = [](const Vector3d& p)
  {
    return octomap::point3d(static_cast<float>(p.x()), static_cast<float>(p.y()),
                            static_cast<float>(p.z()));
  };
  octomap::point3d end;
  for (auto _ : state)
    for (std::size_t k = 0; k < rays.origins.size(); ++k)
      benchmark::DoNotOptimize(
          tree.castRay(point(rays.origins[k]), point(rays.directions[k]), end, true, kRange));
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(rays.origins.size()));
}
BENCHMARK(OctomapCastRay)->Unit(benchmark::kMillisecond);

void OctreeDistance(benchmark::State& state)
{
  const World world = octreeWorld();
  const Rays rays(world);
  for (auto _ : state)
    for (const Vector3d& p : rays.origins) benchmark::DoNotOptimize(world.distance(p));
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(rays.origins.size()));
}
BENCHMARK(OctreeDistance)->Unit(benchmark::kMillisecond);

/// Straight flight at 1 m/s.
struct Straight : Motion
{
  Eigen::Isometry3d pose(double t) const override
  {
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    T.translation() = Vector3d(-19.0 + t, 0.0, 1.5);
    return T;
  }
  MotionSample at(double) const override { return {}; }
};

void wholeScan(benchmark::State& state, const World& world)
{
  Vlp16Model lidar({}, 1);
  std::int64_t rays = 0;
  for (auto _ : state)
    rays += static_cast<std::int64_t>(lidar.nextScan(world, Straight{}).packets.size()) * 384;
  state.SetItemsProcessed(rays);
}
void ScanOfCylinders(benchmark::State& state)
{
  wholeScan(state, World::of(forest(), {}, true));
}
void ScanOfOctree(benchmark::State& state)
{
  wholeScan(state, octreeWorld());
}
BENCHMARK(ScanOfCylinders)->Unit(benchmark::kMillisecond)->Iterations(200);
BENCHMARK(ScanOfOctree)->Unit(benchmark::kMillisecond)->Iterations(200);
}  // namespace
