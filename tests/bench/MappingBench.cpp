// SPDX-License-Identifier: BSD-3-Clause
// Map update and distance transform per lidar scan, beside OctoMap + dynamicEDT3D in the same run.
//
// Times are CPU time of one thread. A vehicle flies at 1.2 m/s through a random forest with a
// 16-beam lidar at 10 Hz. Per scan the time of Mapper::integrate() is taken and, interleaved on the
// same scan, that of the baseline: OcTree::insertPointCloud(discretize), then a DynamicEDTOctomap
// built on the moving window.
#include <benchmark/benchmark.h>
#include <dynamicEDT3D/dynamicEDTOctomap.h>
#include <octomap/OcTree.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <optional>

#include "slalom/core/Rng.h"
#include "slalom/mapping/Mapper.h"

namespace
{
using slalom::core::Ray;
using slalom::core::Rng;
using slalom::mapping::Mapper;
using slalom::mapping::MapperConfig;
using Vec3 = Eigen::Vector3d;

struct Forest
{
  std::vector<Vec3> trunks;  // x, y, radius

  explicit Forest(std::uint64_t seed)
  {
    Rng rng(seed);
    for (int i = 0; i < 0.15 * 80 * 60; ++i)  // trees per square metre, within reach
    {
      const double x = rng.uniform(-40.0, 40.0), y = rng.uniform(-30.0, 30.0);
      if (std::fabs(y) > 0.8) trunks.emplace_back(x, y, rng.uniform(0.1, 0.35));
    }
  }
  // Trunks that a ray from p towards this azimuth could meet.
  [[nodiscard]] std::vector<Vec3> ahead(const Vec3& p, double azimuth) const
  {
    const Eigen::Vector2d across(-std::sin(azimuth), std::cos(azimuth));
    std::vector<Vec3> near;
    for (const Vec3& trunk : trunks)
      if (std::fabs(across.dot(trunk.head<2>() - p.head<2>())) <= trunk.z()) near.push_back(trunk);
    return near;
  }
  // Distance along a unit ray to the nearest of some trunks or the ground at z = 0.
  [[nodiscard]] static std::optional<double> hit(const std::vector<Vec3>& trunks, const Vec3& p,
                                                 const Vec3& d)
  {
    double nearest = d.z() < 0.0 ? -p.z() / d.z() : 100.0;
    const double planar = d.head<2>().squaredNorm();
    for (const Vec3& trunk : trunks)
    {
      const Eigen::Vector2d to = trunk.head<2>() - p.head<2>();
      const double along = to.dot(d.head<2>()) / planar;
      const double miss = (to - along * d.head<2>()).squaredNorm();
      const double inside = trunk.z() * trunk.z() - miss;
      if (along <= 0.0 || inside < 0.0) continue;
      const double range = along - std::sqrt(inside / planar);
      if (range < nearest && p.z() + range * d.z() < 8.0) nearest = range;
    }
    return nearest < 100.0 ? std::optional<double>(nearest) : std::nullopt;
  }
};

struct Scan
{
  Vec3 p;
  std::vector<Ray> rays;
};

std::vector<Scan> flight(int scans)
{
  const Forest forest(1);
  Rng noise(2);
  std::vector<Scan> all;
  for (int k = 0; k < scans; ++k)
  {
    Scan scan{Vec3(-10.0 + 0.12 * k, 0.2 * std::sin(0.05 * k), 1.5), {}};
    for (int azimuth = 0; azimuth < 1800; ++azimuth)
    {
      const double a = azimuth * 2.0 * M_PI / 1800.0;
      const std::vector<Vec3> trunks = forest.ahead(scan.p, a);
      for (int ring = 0; ring < 16; ++ring)
      {
        const double e = (2 * ring - 15) * M_PI / 180.0;
        const Vec3 d(std::cos(e) * std::cos(a), std::cos(e) * std::sin(a), std::sin(e));
        const std::optional<double> range = Forest::hit(trunks, scan.p, d);
        if (!range) continue;
        const Vec3 end = scan.p + (*range + 0.01 * noise.normal()) * d;
        scan.rays.push_back({scan.p.cast<float>(), end.cast<float>()});
      }
    }
    all.push_back(std::move(scan));
  }
  return all;
}

const std::vector<Scan>& scans()
{
  static const std::vector<Scan> all = flight(100);
  return all;
}

// CPU time of this thread, which other programs on the machine disturb less than the clock.
double milliseconds()
{
  std::timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
}

double quantile(std::vector<double> values, double q)
{
  std::sort(values.begin(), values.end());
  return values.empty()
             ? 0.0
             : values[static_cast<std::size_t>(q * static_cast<double>(values.size() - 1))];
}

class Baseline
{
 public:
  explicit Baseline(const MapperConfig& c) : config_(c), tree_(c.resolution_m)
  {
    tree_.setProbHit(c.hit);
    tree_.setProbMiss(c.miss);
    tree_.setClampingThresMin(c.clamp_min);
    tree_.setClampingThresMax(c.clamp_max);
  }
  void integrate(const Scan& scan)
  {
    octomap::Pointcloud cloud;
    for (const Ray& ray : scan.rays) cloud.push_back(ray.end_L.x(), ray.end_L.y(), ray.end_L.z());
    const auto point = [](const Vec3& p)
    {
      return octomap::point3d(static_cast<float>(p.x()), static_cast<float>(p.y()),
                              static_cast<float>(p.z()));
    };
    tree_.insertPointCloud(cloud, point(scan.p), config_.update_range_m, false, true);
    const Vec3 half = 0.5 * Vec3(config_.window_xy_m, config_.window_xy_m, config_.window_z_m);
    DynamicEDTOctomap distances(static_cast<float>(config_.max_distance_m), &tree_,
                                point(scan.p - half), point(scan.p + half), false);
    distances.update();
    benchmark::DoNotOptimize(distances.getDistance(point(scan.p)));
  }

 private:
  MapperConfig config_;
  octomap::OcTree tree_;
};

// Arguments: voxel edge [mm], range [m], window edge [m] and height [m], scans of the baseline.
void mapPerScan(benchmark::State& state)
{
  MapperConfig c;
  c.resolution_m = 1e-3 * static_cast<double>(state.range(0));
  c.update_range_m = static_cast<double>(state.range(1));
  c.window_xy_m = static_cast<double>(state.range(2));
  c.window_z_m = static_cast<double>(state.range(3));
  const int baseline_scans = static_cast<int>(state.range(4));
  (void)scans();
  for (auto _ : state)
  {
    Mapper mapper(c);
    Baseline baseline(c);
    std::vector<double> ours, theirs, paired;
    double points = 0.0;
    for (std::size_t k = 0; k < scans().size(); ++k)
    {
      const Scan& scan = scans()[k];
      const double start = milliseconds();
      (void)mapper.integrate(0.1 * static_cast<double>(k), scan.p, scan.rays);
      ours.push_back(milliseconds() - start);
      points += static_cast<double>(scan.rays.size());
      if (static_cast<int>(k) >= baseline_scans) continue;
      const double baseline_start = milliseconds();
      baseline.integrate(scan);
      theirs.push_back(milliseconds() - baseline_start);
      paired.push_back(ours.back());
    }
    state.SetIterationTime(1e-3 * quantile(ours, 0.5));
    state.counters["points"] = points / static_cast<double>(scans().size());
    state.counters["ms"] = quantile(ours, 0.5);
    state.counters["ms_p95"] = quantile(ours, 0.95);
    state.counters["ms_worst"] = quantile(ours, 1.0);
    if (theirs.empty()) continue;
    state.counters["A_ms"] = quantile(theirs, 0.5);
    state.counters["A_ratio"] = quantile(theirs, 0.5) / quantile(paired, 0.5);
    state.counters["MB"] = 1e-6 * static_cast<double>(mapper.memoryBytes());
  }
}
BENCHMARK(mapPerScan)
    ->ArgNames({"mm", "range", "xy", "z", "A"})
    ->Args({200, 4, 12, 6, 0})
    ->Args({200, 6, 12, 6, 0})
    ->Args({200, 6, 16, 8, 0})
    ->Args({100, 4, 12, 6, 0})
    ->Args({100, 6, 12, 6, 0})
    ->Args({100, 6, 16, 8, 0})
    ->Args({200, 6, 12, 6, 25})
    ->Args({200, 6, 16, 8, 25})
    ->Args({100, 6, 12, 6, 10})
    ->Args({100, 6, 16, 8, 5})
    ->UseManualTime()
    ->Iterations(1)
    ->Unit(benchmark::kMillisecond);

}  // namespace
