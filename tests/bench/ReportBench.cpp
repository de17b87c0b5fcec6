// SPDX-License-Identifier: BSD-3-Clause
// Cost of a report beside the flight: one cycle picture (drawing and encoding), one cycle's rows.
#include <benchmark/benchmark.h>

#include <filesystem>
#include <opencv2/imgcodecs.hpp>

#include "CyclePicture.h"
#include "SyntheticFlight.h"
#include "slalom/report/FlightReport.h"

namespace slalom
{
namespace
{
constexpr int kCycle = 40;  // every part of the record is filled

void drawCycle(benchmark::State& state)
{
  const test::SyntheticFlight flight;
  const report::RunInfo info;
  const report::ReportConfig config;
  report::detail::FlightLog log(info);
  for (int i = 0; i <= kCycle; ++i) log.add(flight.cycle(i));
  const core::CycleRecord record = flight.cycle(kCycle);
  for (auto _ : state)
    benchmark::DoNotOptimize(
        report::detail::drawCyclePicture({record, log.cycles(), info, config}));
}
BENCHMARK(drawCycle)->Unit(benchmark::kMillisecond);

/// Arguments: compression level (-1: OpenCV's fast path with one filter), strategy of zlib.
void encodeCycle(benchmark::State& state)
{
  const test::SyntheticFlight flight;
  const report::RunInfo info;
  report::detail::FlightLog log(info);
  const core::CycleRecord record = flight.cycle(kCycle);
  log.add(record);
  const report::detail::Canvas canvas =
      report::detail::drawCyclePicture({record, log.cycles(), info, {}});
  std::vector<int> settings = {cv::IMWRITE_PNG_STRATEGY, static_cast<int>(state.range(1))};
  if (state.range(0) >= 0)
    settings.insert(settings.begin(),
                    {cv::IMWRITE_PNG_COMPRESSION, static_cast<int>(state.range(0))});
  std::vector<std::uint8_t> bytes;
  for (auto _ : state) cv::imencode(".png", canvas.pixels(), bytes, settings);
  state.counters["kB"] = static_cast<double>(bytes.size()) / 1e3;
}
BENCHMARK(encodeCycle)
    ->ArgsProduct({{-1, 1, 3},
                   {cv::IMWRITE_PNG_STRATEGY_DEFAULT, cv::IMWRITE_PNG_STRATEGY_FILTERED,
                    cv::IMWRITE_PNG_STRATEGY_RLE}})
    ->Unit(benchmark::kMillisecond);

void addWithoutPicture(benchmark::State& state)
{
  const auto folder = std::filesystem::temp_directory_path() / "slalom_bench_report";
  std::filesystem::create_directories(folder);
  const test::SyntheticFlight flight;
  report::ReportConfig config;
  config.picture_interval_s = 0.0;
  report::FlightReport report(config, folder, {});
  core::CycleRecord record = flight.cycle(kCycle);
  for (auto _ : state)
  {
    record.t += 0.1;
    report.add(record);
  }
}
BENCHMARK(addWithoutPicture)->Unit(benchmark::kMicrosecond);
}  // namespace
}  // namespace slalom
