// SPDX-License-Identifier: BSD-3-Clause
#include <benchmark/benchmark.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <memory>
#include <vector>

#include "AnalyticField.h"
#include "Laws.h"
#include "slalom/core/Math.h"
#include "slalom/core/Rng.h"
#include "slalom/core/VelocityResponse.h"
#include "slalom/local_planner/LocalPlanner.h"
#include "slalom/spline/WaypointFit.h"

namespace
{
using namespace slalom;

/// CPU time of this thread [ms]: what a step costs, whatever else the machine does.
double cpuMilliseconds()
{
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) * 1e3 + static_cast<double>(now.tv_nsec) * 1e-6;
}

/// A weaving reference of 40 m and trunks that leave it `gap` metres on either side.
struct Forest
{
  explicit Forest(double gap)
  {
    Eigen::Matrix3Xd waypoints(3, 21);
    for (int i = 0; i <= 20; ++i)
      waypoints.col(i) << 2.0 * i, 1.5 * std::sin(0.5 * i), 1.5 + 0.3 * std::sin(0.66 * i);
    reference =
        std::make_shared<spline::UniformBSpline>(spline::fitWaypoints(waypoints, {1.2, 1.0, 0.2}));
    const Eigen::Matrix3Xd path = reference->sample(reference->start(), reference->end(), 2000);
    core::Rng rng(7);
    std::vector<test::Obstacle> trees;
    while (trees.size() < 80)
    {
      const Eigen::Vector2d centre(rng.uniform(-2.0, 44.0), rng.uniform(-4.0, 4.0));
      const double radius = rng.uniform(0.1, 0.4);
      if ((path.topRows<2>().colwise() - centre).colwise().norm().minCoeff() - radius >= gap)
        trees.push_back(test::VerticalCylinder{centre, radius});
    }
    field = std::make_shared<test::AnalyticField>(trees);
  }
  std::shared_ptr<const spline::UniformBSpline> reference;
  std::shared_ptr<const test::AnalyticField> field;
};

/// Flies the forest once at 20 Hz in closed loop and appends the CPU time of every step.
void fly(const Forest& forest, const local_planner::LocalPlannerConfig& config,
         std::vector<double>& times, double& iterations)
{
  constexpr double kPeriod = 0.05;
  local_planner::LocalPlanner planner(config, core::Vehicle{});
  local_planner::LocalPlannerInput input;
  input.reference = forest.reference;
  input.field = forest.field;
  input.law = test::lawTo(*forest.reference, forest.reference->end());
  input.state.p_L = forest.reference->position(0.0);
  double yaw = 0.0;
  for (double t = 0.0; t < forest.reference->duration(); t += kPeriod)
  {
    input.state.t = t;
    input.state.q_WB = core::fromYaw(yaw);
    input.progress = forest.reference->start() + t;
    const double begin = cpuMilliseconds();
    const local_planner::LocalPlannerOutput output = planner.step(input);
    times.push_back(cpuMilliseconds() - begin);
    iterations += output.report.iterations;
    input.last_command = output.command;
    const core::Motion next = core::held({input.state.p_L, input.state.v_W, yaw, 0.0},
                                         output.command, kPeriod, core::Vehicle{});
    input.state.p_L = next.p;
    input.state.v_W = next.v;
    yaw = next.yaw;
  }
}

double median(std::vector<double>& times)
{
  std::sort(times.begin(), times.end());
  return times[times.size() / 2];
}

/// Arguments: free distance on either side of the reference [cm], obstacle rows per stage.
void BM_LocalPlannerStep(benchmark::State& state)
{
  const Forest forest(0.01 * static_cast<double>(state.range(0)));
  local_planner::LocalPlannerConfig config;
  config.obstacles_per_stage = static_cast<int>(state.range(1));
  std::vector<double> times, reference_times;
  double iterations = 0.0, reference_iterations = 0.0;
  for (auto _ : state) fly(forest, config, times, iterations);
  config.solver = optim::TrackingBackEnd::Ipopt;
  fly(forest, config, reference_times, reference_iterations);
  const auto steps = static_cast<double>(times.size());
  state.counters["median_ms"] = median(times);
  state.counters["ipopt_ratio"] = median(reference_times) / median(times);
  state.counters["p99_ms"] = times[times.size() * 99 / 100];
  state.counters["worst_ms"] = times.back();
  state.counters["iterations"] = iterations / steps;
}
BENCHMARK(BM_LocalPlannerStep)
    ->Args({30, 4})
    ->Args({45, 4})
    ->Args({80, 4})
    ->Args({45, 0})
    ->Iterations(1)
    ->Unit(benchmark::kMillisecond);

}  // namespace
