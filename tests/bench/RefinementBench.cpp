// SPDX-License-Identifier: BSD-3-Clause
// J of Eq. (1) over 40 control points: the second-order method against NLopt's L-BFGS, on the
// instances of the evaluation data and on seeded ones of the same kind. Every benchmark solves all
// instances of its set once per iteration; its counters are over instances, [us] each.
#include <benchmark/benchmark.h>
#include <time.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "RandomRefinement.h"
#include "SharedData.h"
#include "slalom/optim/BoxMinimizer.h"

namespace
{
using namespace slalom;
using global_planner::RefinementCost;
using optim::BoxMethod;
using optim::BoxMinimizerConfig;
using optim::BoxMinimum;

constexpr double kTargetGap = 1e-5;  // relative to the best known cost
constexpr BoxMinimizerConfig kExact{.max_evaluations = 1000, .relative_tolerance = 1e-12};

BoxMinimizerConfig newton(double tolerance)
{
  return {.max_evaluations = 150, .relative_tolerance = tolerance};
}

BoxMinimizerConfig lbfgs(double tolerance)
{
  return {.method = BoxMethod::Lbfgs,
          .max_evaluations = 100000,
          .relative_tolerance = tolerance,
          .memory = 10};
}

struct Instance
{
  Instance(RefinementCost c, Eigen::VectorXd lo, Eigen::VectorXd hi)
      : cost(std::move(c)), start(cost.start()), lower(std::move(lo)), upper(std::move(hi))
  {
    best = std::min(solve(kExact).report.cost, solve(lbfgs(1e-12)).report.cost);
    // The loosest stop that brings L-BFGS to the gap: nobody knows it beforehand.
    for (double tolerance = 1e-4; tolerance > 1e-13; tolerance *= 0.1)
    {
      at_gap = lbfgs(tolerance);
      if (gap(solve(at_gap)) <= kTargetGap) break;
    }
  }
  [[nodiscard]] BoxMinimum solve(const BoxMinimizerConfig& config)
  {
    return optim::minimizeInBox(cost, start, lower, upper, config, core::Deadline::none());
  }
  [[nodiscard]] double gap(const BoxMinimum& found) const
  {
    return (found.report.cost - best) / best;
  }
  RefinementCost cost;
  Eigen::VectorXd start, lower, upper;
  double best = 0.0;
  BoxMinimizerConfig at_gap;
};

/// A reference that goes around a row of pillars with noise, pushed aside where it meets them.
Instance seeded(std::uint64_t seed)
{
  core::Rng rng(seed);
  slalom::test::RefinementInstance made;
  made.lower = Eigen::Vector3d(-5.0, -0.6, 1.3);
  made.upper = Eigen::Vector3d(20.0, 0.6, 1.7);
  made.points.resize(3, 40);
  for (Eigen::Index i = 0; i < 40; ++i)
  {
    const double x = 0.08 * static_cast<double>(i);
    made.points.col(i) = Eigen::Vector3d(x, 0.2 * std::sin(2.0 * x), 1.5) + rng.normal3(0.005);
    if (rng.integer(0, 3) == 0) continue;
    const Eigen::Vector3d side(0.0, std::cos(x), 0.3 * rng.normal());
    made.pulls.push_back(
        {i, made.points.col(i) + rng.uniform(0.0, 0.5) * side.normalized(), side.normalized()});
  }
  const global_planner::test::InstanceProblem given(made);
  return {given.cost(), given.lower, given.upper};
}

/// Empty if the data are absent.
std::vector<Instance>& instances(const std::string& set)
{
  static std::map<std::string, std::vector<Instance>> sets;
  std::vector<Instance>& made = sets[set];
  if (!made.empty()) return made;
  if (set == "seeded")
    for (std::uint64_t seed = 1; seed <= 24; ++seed) made.push_back(seeded(seed));
  else
    for (const auto& read : slalom::test::readRefinementInstances(
             slalom::test::sharedData("problems/J_" + set + "_Nr40.txt")))
    {
      const global_planner::test::InstanceProblem given(read);
      made.emplace_back(given.cost(), given.lower, given.upper);
    }
  return made;
}

double median(std::vector<double> values)
{
  std::nth_element(values.begin(), values.begin() + values.size() / 2, values.end());
  return values[values.size() / 2];
}

/// Of this thread: on a busy machine a long solve is interrupted more often than a short one, and
/// ratios of wall times would flatter the short one.
double cpuMicroseconds()
{
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e6 * static_cast<double>(now.tv_sec) + 1e-3 * static_cast<double>(now.tv_nsec);
}

/// Times of every instance over all passes; the median of each is its time.
class Times
{
 public:
  explicit Times(std::size_t count) : passes_(count) {}
  BoxMinimum measure(std::size_t i, Instance& instance, const BoxMinimizerConfig& config)
  {
    const double begin = cpuMicroseconds();
    BoxMinimum found = instance.solve(config);
    passes_[i].push_back(cpuMicroseconds() - begin);
    return found;
  }
  [[nodiscard]] double last(std::size_t i) const { return passes_[i].back(); }
  [[nodiscard]] std::vector<double> medians() const
  {
    std::vector<double> all;
    for (const auto& pass : passes_) all.push_back(median(pass));
    return all;
  }

 private:
  std::vector<std::vector<double>> passes_;
};

void report(benchmark::State& state, const std::string& name, const std::vector<double>& values)
{
  state.counters[name + "_median"] = median(values);
  state.counters[name + "_worst"] = *std::max_element(values.begin(), values.end());
}

/// One optimiser with one tolerance, beside L-BFGS stopped at the target gap.
void BM_Refinement(benchmark::State& state, const std::string& set,
                   const BoxMinimizerConfig& config)
{
  std::vector<Instance>& all = instances(set);
  if (all.empty())
  {
    state.SkipWithError("the evaluation data are absent");
    return;
  }
  Times times(all.size()), baseline(all.size());
  std::vector<double> gaps(all.size()), iterations(all.size());
  for (auto _ : state)
  {
    double sum = 0.0;
    for (std::size_t i = 0; i < all.size(); ++i)
    {
      const BoxMinimum found = times.measure(i, all[i], config);
      (void)baseline.measure(i, all[i], all[i].at_gap);
      gaps[i] = all[i].gap(found);
      iterations[i] = found.report.iterations;
      sum += times.last(i);
    }
    state.SetIterationTime(1e-6 * sum / static_cast<double>(all.size()));
  }
  std::vector<double> ratios = baseline.medians();
  const std::vector<double> own = times.medians();
  report(state, "us", own);
  report(state, "lbfgs_at_gap_us", ratios);
  for (std::size_t i = 0; i < own.size(); ++i) ratios[i] /= own[i];
  state.counters["lbfgs_at_gap_ratio_median"] = median(ratios);
  report(state, "gap", gaps);
  report(state, "iterations", iterations);
}

void BM_Evaluate(benchmark::State& state)
{
  Instance instance = seeded(1);
  Eigen::VectorXd gradient;
  for (auto _ : state) benchmark::DoNotOptimize(instance.cost.evaluate(instance.start, gradient));
}
BENCHMARK(BM_Evaluate);

void BM_Curvature(benchmark::State& state)
{
  Instance instance = seeded(1);
  optim::BlockBand hessian(instance.start.size() / 3);
  for (auto _ : state)
  {
    instance.cost.curvature(instance.start, hessian);
    benchmark::DoNotOptimize(hessian.diagonal.data());
  }
}
BENCHMARK(BM_Curvature);

void addAll()
{
  for (const std::string set : {"loose", "tight", "seeded"})
    for (const auto& [name, config] :
         {std::pair{"newton_1e-4", newton(1e-4)}, std::pair{"newton_1e-6", newton(1e-6)},
          std::pair{"lbfgs_loose_1e-4", lbfgs(1e-4)}, std::pair{"lbfgs_tight_1e-10", lbfgs(1e-10)}})
      benchmark::RegisterBenchmark(("BM_Refinement/" + set + "/" + name).c_str(), BM_Refinement,
                                   set, config)
          ->UseManualTime()
          ->Iterations(7)  // the baseline costs what the clock of the benchmark does not see
          ->Unit(benchmark::kMicrosecond);
}
[[maybe_unused]] const bool kAdded = (addAll(), true);

}  // namespace
