// SPDX-License-Identifier: BSD-3-Clause
// Decoding of a VLP-16 scan beside MRPT's own, and reading of a rawlog.
#include <benchmark/benchmark.h>
#include <mrpt/obs/CObservationVelodyneScan.h>

#include <cstring>
#include <filesystem>

#include "slalom/core/Rng.h"
#include "slalom/mrpt_io/Encoders.h"
#include "slalom/mrpt_io/RawlogReader.h"
#include "slalom/mrpt_io/RawlogWriter.h"
#include "slalom/mrpt_io/Velodyne.h"

using namespace slalom;
using mrpt::obs::CObservationVelodyneScan;
using mrpt_io::VelodynePacket;

namespace
{
/// One turn of a VLP-16 at 10 Hz with `share` of its 29 184 shots returned.
std::shared_ptr<CObservationVelodyneScan> oneTurn(double share)
{
  core::Rng rng(1);
  std::vector<VelodynePacket> packets(76);
  int block_number = 0;
  for (auto& packet : packets)
  {
    packet = VelodynePacket();
    packet.model = VelodynePacket::kVlp16;
    packet.return_mode = VelodynePacket::kStrongest;
    packet.microseconds = static_cast<std::uint32_t>(block_number * 110.592);
    for (auto& block : packet.blocks)
    {
      block.header = 0xEEFF;
      block.azimuth = static_cast<std::uint16_t>(block_number++ * 39.813);
      for (auto& r : block.returns)
        if (rng.uniform() < share) r.distance = static_cast<std::uint16_t>(rng.integer(600, 60000));
    }
  }
  return std::dynamic_pointer_cast<CObservationVelodyneScan>(
      mrpt_io::makeVelodyneObservation(1.7e9, packets, Eigen::Isometry3d::Identity()));
}

void decodeOurs(benchmark::State& state)
{
  const auto scan = oneTurn(0.77);
  core::RangeScan out;
  std::map<std::string, std::uint64_t> dropped;
  for (auto _ : state) mrpt_io::decodeVelodyne(*scan, out, dropped);
  state.counters["points"] = static_cast<double>(out.points.size());
}
BENCHMARK(decodeOurs)->Unit(benchmark::kMicrosecond);

void decodeMrpt(benchmark::State& state)
{
  const auto scan = oneTurn(0.77);
  for (auto _ : state) scan->generatePointCloud();
  state.counters["points"] = static_cast<double>(scan->point_cloud.size());
}
BENCHMARK(decodeMrpt)->Unit(benchmark::kMicrosecond);

void readRawlog(benchmark::State& state)
{
  const auto file = std::filesystem::temp_directory_path() / "slalom_bench.rawlog";
  {
    mrpt_io::RawlogWriter writer(file);
    const auto scan = oneTurn(0.77);
    for (int i = 0; i < 50; ++i) writer.write(*scan);
    writer.close();
  }
  for (auto _ : state)
  {
    mrpt_io::RawlogReader reader(file);
    while (reader.next())
    {
    }
  }
  state.counters["scans_per_s"] = benchmark::Counter(50.0 * static_cast<double>(state.iterations()),
                                                     benchmark::Counter::kIsRate);
  std::filesystem::remove(file);
}
BENCHMARK(readRawlog)->Unit(benchmark::kMillisecond);
}  // namespace
