// SPDX-License-Identifier: BSD-3-Clause
// Cost of the state estimator per measurement, in steady flight with known heading.
#include <benchmark/benchmark.h>

#include "slalom/estimation/StateEstimator.h"

namespace slalom
{
namespace
{
constexpr double kPeriod = 1.0 / 200.0;

/// A vehicle that hovers; the arithmetic is the same in any flight.
class Hover
{
 public:
  Hover()
  {
    for (int i = 0; i < 600; ++i)
    {
      imu();
      if (i % 10 == 0) velocity(0.0);
      if (i % 40 == 0) position(0.0);
      if (i % 40 == 0) estimator.add(core::YawFix{t, 0.3, 0.05, "compass"});
    }
  }
  void imu() { estimator.add(core::ImuSample{t += kPeriod, {0.0, 0.0, 9.80665}, {0.0, 0.0, 0.0}}); }
  void velocity(double delay)
  {
    estimator.add(core::VelocityFix{t - delay, {0, 0, 0}, {0.1, 0.1, 0.1}, false, "velocity"});
  }
  void position(double delay)
  {
    estimator.add(core::PositionFix{t - delay, {0, 0, 0}, {0.5, 0.5, 0.8}, {0, 0, 0}, "gps"});
  }

  double t = 0.0;
  estimation::StateEstimator estimator{estimation::FilterConfig{}};
};

void ImuSample(benchmark::State& state)
{
  Hover hover;
  for (auto _ : state) hover.imu();
}
BENCHMARK(ImuSample);

/// 20 IMU samples and one fix that is `delay` late; subtract 20 samples for the fix alone.
void LateFix(benchmark::State& state)
{
  Hover hover;
  const double delay = 1e-3 * static_cast<double>(state.range(0)) + 1e-4;
  for (auto _ : state)
  {
    for (int i = 0; i < 20; ++i) hover.imu();
    hover.position(delay);
  }
}
BENCHMARK(LateFix)->Arg(0)->Arg(50)->Arg(200)->Arg(400);

void StateAt(benchmark::State& state)
{
  Hover hover;
  double back = 0.0;
  for (auto _ : state)
  {
    back = back > 0.1 ? 0.0 : back + 3.7e-4;
    benchmark::DoNotOptimize(hover.estimator.stateAt(hover.t - back));
  }
}
BENCHMARK(StateAt);
}  // namespace
}  // namespace slalom
