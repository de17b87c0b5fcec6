// SPDX-License-Identifier: BSD-3-Clause
#include <benchmark/benchmark.h>

#include <deque>

#include "slalom/core/Rng.h"
#include "slalom/optim/PathQp.h"

namespace
{
using namespace slalom;

/// Points on a winding guide, each in one polyhedron of 20 half-spaces that holds its guide point.
struct Chain
{
  explicit Chain(Eigen::Index points)
  {
    core::Rng rng(11);
    Eigen::Vector3d guide = Eigen::Vector3d::Zero(), heading = Eigen::Vector3d::UnitX();
    qp.first = guide;
    qp.points = points;
    qp.margin = 0.5;
    for (Eigen::Index k = 0; k < points; ++k)
    {
      core::HalfSpaces& set = polyhedra.emplace_back();
      set.A.resize(20, 3);
      set.b.resize(20);
      for (int i = 0; i < 20; ++i)
      {
        const Eigen::Vector3d normal = rng.direction();
        set.A.row(i) = normal.transpose();
        set.b[i] = normal.dot(guide) + rng.uniform(0.1, 0.8);
      }
      qp.sets.push_back({&set});
      heading = (heading + 0.5 * rng.direction()).normalized();
      if (k + 1 < points) guide += 0.3 * heading;
    }
    qp.last = guide;
  }
  optim::PathQp qp;
  std::deque<core::HalfSpaces> polyhedra;
};

/// Argument: points of the chain. Time per point shows that the cost is linear.
void BM_PathQp(benchmark::State& state)
{
  const Chain chain(state.range(0));
  int iterations = 0;
  for (auto _ : state)
  {
    const optim::PathQpSolution solution = optim::solve(chain.qp);
    iterations = solution.report.iterations;
    benchmark::DoNotOptimize(solution.points.data());
  }
  state.counters["iterations"] = iterations;
}
BENCHMARK(BM_PathQp)->Arg(15)->Arg(30)->Arg(60)->Arg(120)->Unit(benchmark::kMicrosecond);

}  // namespace
