// SPDX-License-Identifier: BSD-3-Clause
/** Guides through 16 x 16 x 6 m of forest at 0.2 m, start to goal 8 m, over twenty forests.
 * Argument: trunks per square metre in hundredths. */
#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>

#include "AnalyticField.h"
#include "InterpolatedField.h"
#include "slalom/core/Rng.h"
#include "slalom/search/GridSearch.h"

namespace
{
using namespace slalom;

struct Problem
{
  test::InterpolatedField field;
  Eigen::Vector3d start, goal;
};

/// Problems that have a path and no straight one.
std::vector<Problem> makeProblems(double per_square_metre, const search::GridSearchConfig& config)
{
  const Eigen::AlignedBox3d box(Eigen::Vector3d(-8, -8, 0), Eigen::Vector3d(8, 8, 6));
  std::vector<Problem> problems;
  for (std::uint64_t seed = 0; problems.size() < 20; ++seed)
  {
    core::Rng rng(seed);
    std::vector<test::Obstacle> trunks;
    for (int i = 0; i < 256.0 * per_square_metre; ++i)
      trunks.push_back(test::VerticalCylinder{{rng.uniform(-8, 8), rng.uniform(-8, 8)},
                                              rng.uniform(0.15, 0.35)});
    Problem problem{{test::AnalyticField(trunks), box, 0.2}, {-4, 0, 1.5}, {4, 0, 1.5}};
    const auto result = search::findPath(problem.field, problem.start, problem.goal, box, config);
    if (result.status == search::SearchStatus::Found && result.path.cols() > 2)
      problems.push_back(std::move(problem));
  }
  return problems;
}

void Forest(benchmark::State& state)
{
  const search::GridSearchConfig config;
  const auto problems = makeProblems(static_cast<double>(state.range(0)) / 100.0, config);
  double worst = 0.0, expansions = 0.0, ratio = 0.0;
  for (auto _ : state)
  {
    expansions = ratio = 0.0;
    for (const Problem& p : problems)
    {
      const auto begin = std::chrono::steady_clock::now();
      const auto result = search::findPath(p.field, p.start, p.goal, p.field.bounds(), config);
      const std::chrono::duration<double, std::milli> took =
          std::chrono::steady_clock::now() - begin;
      worst = std::max(worst, took.count());
      expansions += result.expansions;
      ratio += result.length_m / 8.0;
    }
  }
  const auto count = static_cast<double>(problems.size());
  state.counters["per_guide"] = benchmark::Counter(
      count, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
  state.counters["worst_ms"] = worst;
  state.counters["expansions"] = expansions / count;
  state.counters["length_ratio"] = ratio / count;
}
BENCHMARK(Forest)->Arg(10)->Arg(20)->Arg(30)->Unit(benchmark::kMillisecond);
}  // namespace
