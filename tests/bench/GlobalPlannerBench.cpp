// SPDX-License-Identifier: BSD-3-Clause
// Whole steps of the global planner, as they come in flight: a vehicle follows plan after plan
// through random forests of which it sees what is nearer than 6 m. Times are CPU time.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <ctime>
#include <vector>

#include "slalom/core/Rng.h"
#include "slalom/global_planner/GlobalPlanner.h"
#include "slalom/mapping/EdtSnapshot.h"
#include "slalom/spline/WaypointFit.h"

namespace slalom
{
namespace
{
using core::Occupancy;

constexpr double kLength = 30.0, kSight = 6.0;

/// CPU time of this thread [s]: what a step costs, whatever else the machine does.
double cpuSeconds()
{
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

struct Tree
{
  Eigen::Vector2d centre;
  double radius;
};

std::vector<Tree> plant(std::uint64_t seed, double density)
{
  core::Rng rng(seed);
  std::vector<Tree> trees;
  const auto count = static_cast<std::size_t>(density * kLength * 16.0);
  while (trees.size() < count)
  {
    const Tree tree{{rng.uniform(0.0, kLength), rng.uniform(-8.0, 8.0)}, rng.uniform(0.15, 0.4)};
    if (tree.centre.norm() > 1.5 && (tree.centre - Eigen::Vector2d(kLength, 0.0)).norm() > 1.5)
      trees.push_back(tree);
  }
  return trees;
}

/// A window of 16 x 16 x 4 m around the vehicle: trees in sight are occupied, all else is free.
std::shared_ptr<const core::DistanceField> look(const std::vector<Tree>& trees,
                                                const Eigen::Vector3d& p, double resolution)
{
  const Eigen::Vector3i size = (Eigen::Vector3d(16.0, 16.0, 4.0) / resolution).cast<int>();
  const Eigen::Vector3d origin =
      ((p - Eigen::Vector3d(8.0, 8.0, 2.0)) / resolution).array().floor() * resolution;
  std::vector<Occupancy> cells(static_cast<std::size_t>(size.prod()), Occupancy::Free);
  for (const Tree& tree : trees)
  {
    if ((tree.centre - p.head<2>()).norm() > kSight) continue;
    const Eigen::Vector2d low = (tree.centre - origin.head<2>()).array() - tree.radius;
    const int reach = static_cast<int>(2.0 * tree.radius / resolution) + 1;
    for (int y = 0; y <= reach; ++y)
      for (int x = 0; x <= reach; ++x)
      {
        const int cx = static_cast<int>(low.x() / resolution) + x;
        const int cy = static_cast<int>(low.y() / resolution) + y;
        if (cx < 0 || cy < 0 || cx >= size.x() || cy >= size.y()) continue;
        const Eigen::Vector2d c =
            origin.head<2>() + resolution * Eigen::Vector2d(cx + 0.5, cy + 0.5);
        if ((c - tree.centre).norm() > tree.radius + 0.5 * resolution) continue;
        for (int z = 0; z < size.z(); ++z)
          cells[(static_cast<std::size_t>(z) * size.y() + cy) * size.x() + cx] =
              Occupancy::Occupied;
      }
  }
  return mapping::EdtSnapshot::fromOccupancy(origin, size, resolution, cells, 3.0);
}

struct Times
{
  std::vector<double> all, led;  ///< [s] every step; steps that led around something
  int refused = 0;
};

void fly(std::uint64_t seed, double density, double resolution, Times& times)
{
  const core::Vehicle vehicle{0.3, 1.8, 2.1, 1.5};
  global_planner::GlobalPlannerConfig config;
  config.clearance_m = 0.6;
  const global_planner::GlobalPlanner planner(config, vehicle);
  const std::vector<Tree> trees = plant(seed, density);
  Eigen::Matrix3Xd ends(3, 2);
  ends << 0, kLength, 0, 0, 1.5, 1.5;
  global_planner::GlobalPlannerInput input;
  input.reference = std::make_shared<const spline::UniformBSpline>(
      spline::fitWaypoints(ends, {vehicle.max_speed_mps, vehicle.max_acceleration_mps2, 0.2}));
  input.state.p_L = input.reference->position(0.0);
  for (int k = 0; k < 400; ++k)
  {
    input.field = look(trees, input.state.p_L, resolution);
    const double started = cpuSeconds();
    const global_planner::GlobalPlannerOutput output = planner.step(input);
    const double spent = cpuSeconds() - started;
    times.all.push_back(spent);
    if (!output.record.guides.empty()) times.led.push_back(spent);
    times.refused += !output.record.certified;
    input.previous = output.refined;
    const auto& plan = *output.refined;
    input.progress = plan.law.advance(input.progress, 0.1);
    input.pace = plan.law.pace(input.progress);
    input.state.p_L = plan.spline.position(input.progress);
    input.state.v_W = input.pace * plan.spline.velocity(input.progress);
    if (plan.referenceTime(input.progress) > input.reference->end() - 2.0) break;
  }
}

double quantile(std::vector<double>& values, double share)
{
  if (values.empty()) return 0.0;
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(share * double(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return 1e3 * *at;
}

void BM_Step(benchmark::State& state)
{
  const double density = 0.01 * static_cast<double>(state.range(0));
  const double resolution = 0.01 * static_cast<double>(state.range(1));
  Times times;
  std::uint64_t seed = 0;
  for (auto _ : state)
  {
    const std::size_t before = times.all.size();
    fly(++seed, density, resolution, times);
    double spent = 0.0;
    for (std::size_t k = before; k < times.all.size(); ++k) spent += times.all[k];
    state.SetIterationTime(spent / double(times.all.size() - before));
  }
  state.counters["steps"] = double(times.all.size());
  state.counters["refused"] = double(times.refused);
  state.counters["median_ms"] = quantile(times.all, 0.5);
  state.counters["p99_ms"] = quantile(times.all, 0.99);
  state.counters["worst_ms"] = quantile(times.all, 1.0);
  state.counters["led_median_ms"] = quantile(times.led, 0.5);
  state.counters["led_p99_ms"] = quantile(times.led, 0.99);
}
BENCHMARK(BM_Step)
    ->ArgNames({"trees_per_100m2", "voxel_cm"})
    ->ArgsProduct({{10, 20, 30}, {20, 10}})
    ->Iterations(10)
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace slalom
