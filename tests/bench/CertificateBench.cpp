// SPDX-License-Identifier: BSD-3-Clause
/** Proofs of clearance over an 8 m window (40 control points 0.2 m apart) through a forest, beside
 * exact distances of dense samples 1 cm apart, which prove nothing. Arguments: voxel edge [mm],
 * room that trunks leave beside the curve beyond the required clearance [mm], 1 = unknown is
 * occupied. Twenty forests; the counters are per curve, in processor time. */
#include <benchmark/benchmark.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <map>
#include <utility>
#include <vector>

#include "slalom/core/Rng.h"
#include "slalom/global_planner/Certificate.h"
#include "slalom/mapping/EdtSnapshot.h"

namespace
{
using namespace slalom;
using core::Occupancy;
using core::UnknownAs;
using Vec3 = Eigen::Vector3d;

constexpr double kClearance = 0.45;  // [m]

struct Problem
{
  spline::UniformBSpline curve;
  std::shared_ptr<const mapping::EdtSnapshot> field;
};

spline::UniformBSpline windingCurve(core::Rng& rng)
{
  Eigen::Matrix3Xd points(3, 40);
  Vec3 p(-3.9, rng.uniform(-1.0, 1.0), 2.0);
  const double phase = rng.uniform(0.0, 6.3);
  for (Eigen::Index i = 0; i < 40; ++i)
  {
    points.col(i) = p;
    const double heading = 0.6 * std::sin(phase + 0.35 * double(i));
    p += 0.2 * Vec3(std::cos(heading), std::sin(heading), 0.1 * std::sin(0.2 * double(i)));
  }
  return {points, 0.2};
}

/// Calls visit(x, y, cell) for the columns of voxels that a round trunk touches.
template <class Visit>
void forCells(const Eigen::Vector2d& trunk, double radius, double r, const Visit& visit)
{
  const int lo_x = int(std::floor((trunk.x() - radius + 8.0) / r)),
            hi_x = int(std::floor((trunk.x() + radius + 8.0) / r)),
            lo_y = int(std::floor((trunk.y() - radius + 8.0) / r)),
            hi_y = int(std::floor((trunk.y() + radius + 8.0) / r));
  for (int y = lo_y; y <= hi_y; ++y)
    for (int x = lo_x; x <= hi_x; ++x)
    {
      const Eigen::Vector2d low(-8.0 + r * x, -8.0 + r * y);
      const Eigen::AlignedBox2d cell(low, low + Eigen::Vector2d::Constant(r));
      if (cell.exteriorDistance(trunk) < radius) visit(x, y, cell);
    }
}

Problem makeProblem(std::uint64_t seed, double r, double room)
{
  core::Rng rng(seed);
  const spline::UniformBSpline curve = windingCurve(rng);
  const Eigen::Matrix3Xd dense = curve.sample(curve.start(), curve.end(), 1500);
  const int n = int(std::round(16.0 / r)), nz = int(std::round(6.0 / r));
  std::vector<std::uint8_t> plan(std::size_t(n) * n, 0);
  int trunks = 0;
  for (int attempt = 0; attempt < 40000 && trunks < 50; ++attempt)
  {
    const Eigen::Vector2d trunk(rng.uniform(-7, 7), rng.uniform(-7, 7));
    const double radius = rng.uniform(0.1, 0.35);
    const double roughly =
        std::sqrt((dense.topRows<2>().colwise() - trunk).colwise().squaredNorm().minCoeff());
    if (roughly < kClearance + radius) continue;
    if (trunks < 16 && roughly > kClearance + room + radius + 1.5 * r) continue;
    double nearest = 1e9;
    forCells(trunk, radius, r,
             [&](int, int, const Eigen::AlignedBox2d& cell)
             {
               for (const auto p : dense.colwise())
                 nearest = std::min(nearest, cell.exteriorDistance(p.head<2>().eval()));
             });
    if (nearest < kClearance + room) continue;
    // Beside the curve, trunks stand as near as the room permits.
    if (trunks < 16 && nearest > kClearance + room + 0.02) continue;
    ++trunks;
    forCells(trunk, radius, r, [&](int x, int y, auto) { plan[std::size_t(y) * n + x] = 1; });
  }
  std::vector<Occupancy> cells;
  for (int z = 0; z < nz; ++z)
    for (const std::uint8_t taken : plan)
      cells.push_back(taken || z == 0 ? Occupancy::Occupied : Occupancy::Free);
  return {curve, mapping::EdtSnapshot::fromOccupancy({-8, -8, 0}, {n, n, nz}, r, cells, 3.0)};
}

const std::vector<Problem>& problemsOf(const benchmark::State& state)
{
  static std::map<std::pair<std::int64_t, std::int64_t>, std::vector<Problem>> made;
  std::vector<Problem>& problems = made[{state.range(0), state.range(1)}];
  if (!problems.empty()) return problems;
  for (std::uint64_t seed = 0; seed < 20; ++seed)
    problems.push_back(
        makeProblem(seed, 1e-3 * double(state.range(0)), 1e-3 * double(state.range(1))));
  return problems;
}

/// Time that this thread has had of the processor: other programs do not count.
double threadMicroseconds()
{
  std::timespec now;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e6 * double(now.tv_sec) + 1e-3 * double(now.tv_nsec);
}

template <class Check>
void run(benchmark::State& state, const Check& check)
{
  const std::vector<Problem>& problems = problemsOf(state);
  const UnknownAs unknown = state.range(2) ? UnknownAs::Occupied : UnknownAs::Free;
  std::vector<double> times;
  double clear = 0.0;
  for (auto _ : state)
  {
    clear = 0.0;
    for (const Problem& p : problems)
    {
      const double begin = threadMicroseconds();
      clear += check(p, unknown);
      times.push_back(threadMicroseconds() - begin);
    }
  }
  std::sort(times.begin(), times.end());
  state.counters["median_us"] = times[times.size() / 2];
  state.counters["p99_us"] = times[times.size() * 99 / 100];
  state.counters["worst_us"] = times.back();
  state.counters["clear_of_20"] = clear;
}

void Certify(benchmark::State& state)
{
  run(state,
      [](const Problem& p, UnknownAs unknown)
      {
        return global_planner::certify(p.curve, p.curve.start(), p.curve.end(), *p.field, unknown,
                                       kClearance)
            .holds(p.curve.end());
      });
}

void DenseExact(benchmark::State& state)
{
  run(state,
      [](const Problem& p, UnknownAs unknown)
      {
        const int count = int(p.curve.length(p.curve.start(), p.curve.end()) / 0.01);
        double least = 1e9;
        for (int i = 0; i <= count; ++i)
        {
          const Vec3 point = p.curve.position(p.curve.start() + p.curve.duration() * i / count);
          least = std::min(least,
                           p.field->hullBound(point.replicate<1, 4>(), unknown, kClearance + 0.01));
        }
        return least >= kClearance;
      });
}

// Room: 0.5 m is comfortable; then gaps that are 5 cm, 1 cm and 1 mm wider than needed; then a
// curve that comes 2 cm too near.
void arguments(benchmark::internal::Benchmark* bench)
{
  for (const int voxel : {200, 100})
    for (const int room : {500, 50, 10, 1, -20}) bench->Args({voxel, room, 1});
}
BENCHMARK(Certify)->Apply(arguments)->Unit(benchmark::kMicrosecond);
BENCHMARK(DenseExact)->Apply(arguments)->Unit(benchmark::kMicrosecond);

}  // namespace
