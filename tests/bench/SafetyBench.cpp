// SPDX-License-Identifier: BSD-3-Clause
/** A pass of the output gate over the ticks of flights along a slalom with a map of voxels: trunks
 * leave the curve the vehicle's radius and a margin. Arguments: voxel edge [mm], margin [mm], what
 * is wanted: 0 = to track the plan, 1 = straight on at full speed, 2 = that without a plan to stop
 * along, so that the gate must look for something better where trunks come. In processor time. */
#include <benchmark/benchmark.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <vector>

#include "slalom/core/Rng.h"
#include "slalom/mapping/EdtSnapshot.h"
#include "slalom/safety/OutputGate.h"

namespace
{
using namespace slalom;
using Vec3 = Eigen::Vector3d;

constexpr double kSpeed = 1.0, kWeave = 0.45, kOmega = 1.2, kLength = 14.0, kPeriod = 0.05;

Vec3 place(double s)
{
  return {kSpeed * s, kWeave * std::sin(kOmega * s), 0.0};
}
Vec3 velocity(double s)
{
  return {kSpeed, kWeave * kOmega * std::cos(kOmega * s), 0.0};
}
Vec3 acceleration(double s)
{
  return {0.0, -kWeave * kOmega * kOmega * std::sin(kOmega * s), 0.0};
}

safety::StopPath stopFrom(double s)
{
  safety::StopPath path;
  double pace = 1.0;
  for (double tau = 0.0; pace > 0.0; tau += path.step_s)
  {
    path.p_L.push_back(place(s));
    path.v_L.push_back(pace * velocity(s));
    const double next = tau < 2.5 ? 1.0 : std::max(0.0, pace - 0.3 * path.step_s);
    s += 0.5 * (pace + next) * path.step_s;
    pace = next;
  }
  path.v_L.back().setZero();
  return path;
}

/// Voxels of trunks; every trunk is tried out and left away if it comes too near.
std::shared_ptr<const mapping::EdtSnapshot> forest(std::uint64_t seed, double voxel, double gap)
{
  const Vec3 origin(-3.0, -5.0, -2.5);
  const Eigen::Vector3i size = (Vec3(kLength + 8.0, 10.0, 5.0) / voxel).array().round().cast<int>();
  std::vector<std::uint8_t> plan(std::size_t(size.x()) * size.y(), 0);
  std::vector<Vec3> way;
  for (double s = -2.0; s < kLength + 5.0; s += 0.02) way.push_back(place(s));
  core::Rng rng(seed);
  for (int trunk = 0; trunk < 3000; ++trunk)
  {
    const Eigen::Vector2d centre(rng.uniform(0.0, kLength + 4.0), rng.uniform(-3.0, 3.0));
    const double radius = rng.uniform(0.1, 0.35);
    std::vector<std::size_t> cells;
    double nearest = 1e9;
    for (int y = 0; y < size.y(); ++y)
      for (int x = 0; x < size.x(); ++x)
      {
        const Eigen::Vector2d low = origin.head<2>() + voxel * Eigen::Vector2d(x, y);
        const Eigen::AlignedBox2d cell(low, low + Eigen::Vector2d::Constant(voxel));
        if (cell.exteriorDistance(centre) >= radius) continue;
        cells.push_back(std::size_t(y) * size.x() + x);
        for (const Vec3& p : way)
          nearest = std::min(nearest, cell.exteriorDistance(p.head<2>().eval()));
      }
    if (nearest < gap || (trunk > 40 && nearest > gap + 0.03)) continue;
    for (const std::size_t cell : cells) plan[cell] = 1;
  }
  std::vector<core::Occupancy> cells;
  for (int z = 0; z < size.z(); ++z)
    for (const std::uint8_t taken : plan)
      cells.push_back(taken ? core::Occupancy::Occupied : core::Occupancy::Free);
  return mapping::EdtSnapshot::fromOccupancy(origin, size, voxel, cells, 3.0);
}

double threadMicroseconds()
{
  std::timespec now;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e6 * double(now.tv_sec) + 1e-3 * double(now.tv_nsec);
}

void Pass(benchmark::State& state)
{
  core::Vehicle vehicle;
  const double voxel = 1e-3 * double(state.range(0)), margin = 1e-3 * double(state.range(1));
  safety::SafetyConfig config;
  config.fence_min_z_m = -1.2;  // as in flight: never lower
  const safety::OutputGate gate(config, vehicle);
  std::vector<safety::GateInput> inputs;
  std::vector<safety::StopPath> stops;
  stops.reserve(4000);
  for (std::uint64_t seed = 0; seed < 6; ++seed)
  {
    core::Rng rng(seed + 50);
    const auto field = forest(seed, voxel, vehicle.radius_m + margin);
    for (double s = 0.0; s < kLength; s += kPeriod)
    {
      safety::GateInput in;
      in.t = in.state.t = s;
      in.state.p_L = in.state.p_W = place(s) + 0.01 * rng.uniform3(-1, 1);
      in.state.v_W = velocity(s) + 0.02 * rng.uniform3(-1, 1);
      in.plan_age_s = 0.0;
      in.field = field;
      in.last.v_W = velocity(s - kPeriod) + vehicle.velocity_lag_s * acceleration(s - kPeriod);
      in.wanted.v_W = state.range(2) ? Vec3(2.0 * velocity(s))
                                     : Vec3(velocity(s) + vehicle.velocity_lag_s * acceleration(s));
      stops.push_back(stopFrom(s));
      if (state.range(2) < 2) in.plan = &stops.back();
      inputs.push_back(in);
    }
  }
  std::vector<double> times;
  int touched = 0, braking = 0;
  for (auto _ : state)
  {
    touched = braking = 0;
    for (const safety::GateInput& in : inputs)
    {
      const double begin = threadMicroseconds();
      const safety::GateOutput out = gate.pass(in);
      times.push_back(threadMicroseconds() - begin);
      touched += out.intervention == safety::Intervention::NoStop;
      braking += out.stop_plan == nullptr;
    }
  }
  std::sort(times.begin(), times.end());
  state.counters["median_us"] = times[times.size() / 2];
  state.counters["p99_us"] = times[times.size() * 99 / 100];
  state.counters["worst_us"] = times.back();
  state.counters["passes"] = double(inputs.size());
  state.counters["no_stop"] = touched;
  state.counters["straight"] = braking;
}

/** The vehicle stands among the trunks, or flies along them, while somebody walks into it from
 * every side in turn. Arguments: voxel edge [mm], speed [m/s]. */
void Evade(benchmark::State& state)
{
  const core::Vehicle vehicle;
  const double voxel = 1e-3 * double(state.range(0)), speed = double(state.range(1));
  safety::SafetyConfig config;
  config.fence_min_z_m = -1.2;
  const safety::OutputGate gate(config, vehicle);
  std::vector<double> times;
  int evading = 0, passes = 0;
  for (auto _ : state)
    for (std::uint64_t seed = 0; seed < 6; ++seed)
    {
      core::Rng rng(seed + 80);
      const auto field = forest(seed, voxel, vehicle.radius_m + 0.3);
      for (double s = 1.0; s < kLength; s += 0.5)
        for (double away = 0.9; away < 4.0; away += 0.2)
        {
          const double course = rng.uniform(0.0, 6.28), pace = rng.uniform(0.3, 1.2);
          const Vec3 from(std::cos(course), std::sin(course), 0.0);
          const core::MovingObstacle mover{.p_L = place(s) + away * from,
                                           .v_L = -pace * from,
                                           .radius_m = 0.4,
                                           .half_axis_m = 0.9,
                                           .sigma_p_m = 0.05,
                                           .sigma_v_mps = 0.1};
          safety::GateInput in;
          in.state.p_L = in.state.p_W = place(s);
          in.plan_age_s = 0.0;
          in.field = field;
          in.last.v_W = in.wanted.v_W = in.state.v_W = speed * velocity(s);
          in.movers = std::span(&mover, 1);
          const double begin = threadMicroseconds();
          const safety::GateOutput out = gate.pass(in);
          times.push_back(threadMicroseconds() - begin);
          evading += out.evasion.for_s > 0.0;
          ++passes;
        }
    }
  std::sort(times.begin(), times.end());
  state.counters["median_us"] = times[times.size() / 2];
  state.counters["p99_us"] = times[times.size() * 99 / 100];
  state.counters["worst_us"] = times.back();
  state.counters["evading"] = double(evading) / passes;
}

BENCHMARK(Evade)->ArgsProduct({{200, 100}, {0, 1}})->Unit(benchmark::kMillisecond);

BENCHMARK(Pass)
    ->ArgsProduct({{200, 100}, {1000, 300, 50}, {0, 1, 2}})
    ->Unit(benchmark::kMillisecond);

}  // namespace
