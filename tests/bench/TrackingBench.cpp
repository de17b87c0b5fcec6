// SPDX-License-Identifier: BSD-3-Clause
#include <benchmark/benchmark.h>

#include <algorithm>
#include <ctime>
#include <vector>

#include "TrackingProblems.h"

namespace
{
using namespace slalom;

/// CPU time of this thread [us]: what a solve costs, whatever else the machine does.
double cpuMicroseconds()
{
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) * 1e6 + static_cast<double>(now.tv_nsec) * 1e-3;
}

struct Sample
{
  std::vector<double> times;
  double iterations = 0.0, converged = 0.0;

  void add(double time, const core::SolveReport& report)
  {
    times.push_back(time);
    iterations += report.iterations;
    converged += report.converged() ? 1.0 : 0.0;
  }
  double quantile(double q)
  {
    const auto at = static_cast<std::ptrdiff_t>(q * static_cast<double>(times.size() - 1));
    std::nth_element(times.begin(), times.begin() + at, times.end());
    return times[static_cast<std::size_t>(at)];
  }
};

/// Both solvers on the same programs and guesses of the same flights; the interior point flies.
void run(benchmark::State& state, double pushed)
{
  test::TrackingFlight::Setting setting;
  setting.stages = static_cast<int>(state.range(0));
  setting.rows = static_cast<int>(state.range(1));
  setting.lag = static_cast<double>(state.range(2)) * 1e-3;
  setting.dt = setting.lag > 0.0 ? 0.1 : 0.05;
  setting.wind = 0.05;
  setting.pushed = pushed;
  const auto riccati = optim::makeTrackingSolver<3>({}, setting.stages, setting.rows);
  const auto ipopt = optim::makeTrackingSolver<3>(
      {.back_end = optim::TrackingBackEnd::Ipopt, .max_iterations = 100}, setting.stages,
      setting.rows);
  Sample ours, theirs;
  double worst_gap = 0.0;
  std::uint64_t seed = 0;
  for (auto _ : state)
  {
    test::TrackingFlight flight(setting, ++seed);
    for (int cycle = 0; cycle < 250; ++cycle)
    {
      const optim::TrackingQp<3>& qp = flight.next();
      const double begin = cpuMicroseconds();
      const auto& a = riccati->solve(qp, flight.guess(), core::Deadline::none());
      ours.add(cpuMicroseconds() - begin, a.report);
      // Every tenth is enough to know a solver that takes a hundred times longer.
      if (cycle % 10 == 0)
      {
        const double between = cpuMicroseconds();
        const auto& b = ipopt->solve(qp, flight.guess(), core::Deadline::none());
        theirs.add(cpuMicroseconds() - between, b.report);
        if (a.report.converged() && b.report.converged())
          worst_gap = std::max(worst_gap, (a.report.cost - b.report.cost) / (1.0 + b.report.cost));
      }
      flight.fly(a.inputs);
    }
  }
  const double solves = static_cast<double>(ours.times.size());
  const double references = static_cast<double>(theirs.times.size());
  state.counters["us_median"] = ours.quantile(0.5);
  state.counters["us_p99"] = ours.quantile(0.99);
  state.counters["us_worst"] = ours.quantile(1.0);
  state.counters["iterations"] = ours.iterations / solves;
  state.counters["converged"] = ours.converged / solves;
  state.counters["ipopt_us_median"] = theirs.quantile(0.5);
  state.counters["ipopt_us_p99"] = theirs.quantile(0.99);
  state.counters["ipopt_iterations"] = theirs.iterations / references;
  state.counters["ipopt_converged"] = theirs.converged / references;
  state.counters["ratio"] = theirs.quantile(0.5) / ours.quantile(0.5);
  state.counters["worst_gap"] = worst_gap;
}

void BM_Tracking(benchmark::State& state)
{
  run(state, 0.0);
}
void BM_TrackingFromInsideTheMargin(benchmark::State& state)
{
  run(state, 0.5);
}

// Stages, rows per stage, lag [ms].
BENCHMARK(BM_Tracking)
    ->ArgsProduct({{10, 15, 20, 25, 40}, {0, 2, 8}, {0, 200}})
    ->ArgNames({"N", "M", "lag_ms"})
    ->Iterations(10)
    ->Unit(benchmark::kMillisecond);
BENCHMARK(BM_TrackingFromInsideTheMargin)
    ->ArgsProduct({{15, 25}, {8}, {0, 200}})
    ->ArgNames({"N", "M", "lag_ms"})
    ->Iterations(10)
    ->Unit(benchmark::kMillisecond);

}  // namespace
