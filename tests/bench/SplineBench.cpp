// SPDX-License-Identifier: BSD-3-Clause
#include <benchmark/benchmark.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <numbers>
#include <vector>

#include "slalom/core/Rng.h"
#include "slalom/spline/TimeLaw.h"
#include "slalom/spline/WaypointFit.h"

namespace
{
using namespace slalom;
using spline::TimeLaw;
using spline::UniformBSpline;

constexpr spline::MotionLimits kVehicle{1.2, 1.0};

/// CPU time of this thread [us]: what a call costs, whatever else the machine does.
double cpuMicroseconds()
{
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) * 1e6 + static_cast<double>(now.tv_nsec) * 1e-3;
}

/// Reference through a slalom of 60 m; `pushed` moves control points as a refinement does.
UniformBSpline reference(double pushed)
{
  Eigen::Matrix3Xd waypoints(3, 31);
  for (int i = 0; i <= 30; ++i)
    waypoints.col(i) << 2.0 * i, 1.5 * std::sin(0.5 * i), 1.5 + 0.3 * std::sin(0.66 * i);
  const UniformBSpline r = spline::fitWaypoints(waypoints, {1.2, 1.0, 0.2});
  Eigen::Matrix3Xd points = r.controlPoints();
  core::Rng rng(5);
  for (Eigen::Index bump = 20; bump + 20 < points.cols(); bump += 25)
  {
    const double height = pushed * rng.uniform(-1.0, 1.0);
    for (Eigen::Index i = -10; i <= 10; ++i)
      points(1, bump + i) +=
          height * std::pow(std::cos(0.05 * std::numbers::pi * static_cast<double>(i)), 2);
  }
  return r.withControlPoints(std::move(points));
}

void report(benchmark::State& state, std::vector<double>& us)
{
  std::sort(us.begin(), us.end());
  state.counters["median_us"] = us[us.size() / 2];
  state.counters["p99_us"] = us[us.size() * 99 / 100];
  state.counters["worst_us"] = us.back();
}

/// Arguments: height of the bumps [cm]; length of the window [0.1 s]; start pace [%].
void BM_TimeLaw(benchmark::State& state)
{
  const UniformBSpline curve = reference(0.01 * static_cast<double>(state.range(0)));
  const double window = 0.1 * static_cast<double>(state.range(1));
  const double start_pace = 0.01 * static_cast<double>(state.range(2));
  std::vector<double> us;
  double from = curve.start() + 1.0, excess = 0.0;
  for (auto _ : state)
  {
    const double begin = cpuMicroseconds();
    const TimeLaw law(curve, from, from + window, start_pace, kVehicle);
    us.push_back(cpuMicroseconds() - begin);
    excess = std::max(excess, law.excess());
    from = from + window + 0.05 < curve.end() ? from + 0.05 : curve.start() + 1.0;
  }
  report(state, us);
  state.counters["excess"] = excess;
}
BENCHMARK(BM_TimeLaw)
    ->Args({0, 120, 0})      // R as it is; 12 s are 60 knots, 240 intervals
    ->Args({60, 120, 0})     // refined
    ->Args({200, 120, 0})    // pushed far: limits bind nearly everywhere
    ->Args({200, 120, 100})  // ... and met too fast
    ->Args({0, 5, 100})      // an emergency: less than the braking distance
    ->Unit(benchmark::kMicrosecond);

/// The horizon of a local plan: 40 steps of 50 ms, with pace and pace change. Time per step.
void BM_TimeLawAdvance(benchmark::State& state)
{
  const UniformBSpline curve = reference(0.6);
  const TimeLaw law(curve, 5.0, 17.0, 0.0, kVehicle);
  double from = 5.0, sum = 0.0;
  for (auto _ : state)
  {
    double t = from;
    for (int i = 0; i < 40; ++i)
    {
      t = law.advance(t, 0.05);
      sum += law.pace(t) + law.paceChange(t);
    }
    from = from < 10.0 ? from + 0.01 : 5.0;
  }
  benchmark::DoNotOptimize(sum);
  state.SetItemsProcessed(40 * state.iterations());
}
BENCHMARK(BM_TimeLawAdvance)->Unit(benchmark::kMicrosecond);

}  // namespace
