// SPDX-License-Identifier: BSD-3-Clause
// Time of one tracker update per scan of a 16-ring lidar (28 800 firings) in a forest, with and
// without people in it. CPU time of one thread; median, p99 and worst of all scans.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <ctime>

#include "MovingScene.h"
#include "slalom/tracking/MoverTracker.h"

namespace
{
using slalom::core::Ray;
using slalom::tracking::MoverTracker;
using slalom::tracking::TrackingConfig;
using Vec3 = Eigen::Vector3d;

struct Scan
{
  Vec3 p;
  std::vector<Ray> rays;
};

std::vector<Scan> flight(int people)
{
  constexpr int kScans = 100;
  slalom::core::Rng rng(2);
  auto scene = slalom::test::difficultForest(1, 40.0, 30.0);
  // What lies behind: nearly every firing has a return, as in a real forest.
  for (int i = 0; i < 400; ++i)
  {
    const double a = 0.0157 * i;
    scene.trunks.push_back({{45.0 * std::cos(a), 45.0 * std::sin(a)}, 0.4, 0.0, 25.0});
  }
  std::vector<slalom::test::MovingBody> bodies;
  for (int i = 0; i < people; ++i)
    bodies.push_back(
        {Vec3(3.0 + 3.0 * i, 2.0 - i, 0.9), Vec3(-0.2 * i, 0.8 - 0.3 * i, 0), 0.2, 0.9});
  const slalom::test::SpinningLidar lidar;
  std::vector<Scan> all;
  const Vec3 v(1.2, 0.0, 0.0);
  for (int k = 0; k < kScans; ++k)
  {
    const Vec3 p = Vec3(-5.0, 0.0, 1.5) + 0.1 * k * v;
    all.push_back({p, lidar.scan(scene, bodies, rng, 0.1 * k, p, v)});
  }
  return all;
}

double milliseconds()
{
  std::timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
}

void update(benchmark::State& state)
{
  const std::vector<Scan> scans = flight(static_cast<int>(state.range(0)));
  std::vector<double> times;
  double rays = 0.0, objects = 0.0, movers = 0.0;
  for (auto _ : state)
  {
    MoverTracker tracker{TrackingConfig{}};
    for (std::size_t k = 0; k < scans.size(); ++k)
    {
      const double start = milliseconds();
      const auto out =
          tracker.update(0.1 * static_cast<double>(k), scans[k].p, scans[k].rays, nullptr);
      times.push_back(milliseconds() - start);
      rays += static_cast<double>(scans[k].rays.size());
      objects += out.objects;
      movers += static_cast<double>(out.movers.size());
    }
  }
  std::sort(times.begin(), times.end());
  const auto count = static_cast<double>(times.size());
  state.counters["median_ms"] = times[times.size() / 2];
  state.counters["p99_ms"] = times[times.size() * 99 / 100];
  state.counters["worst_ms"] = times.back();
  state.counters["rays"] = rays / count;
  state.counters["objects"] = objects / count;
  state.counters["movers"] = movers / count;
}
BENCHMARK(update)->ArgName("people")->Arg(0)->Arg(3)->Unit(benchmark::kMillisecond)->Iterations(5);

}  // namespace
