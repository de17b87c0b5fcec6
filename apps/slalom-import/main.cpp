// SPDX-License-Identifier: BSD-3-Clause
#include <Eigen/Geometry>
#include <filesystem>
#include <iostream>
#include <numbers>
#include <optional>

#include "Program.h"
#include "slalom/mrpt_io/MemoryLimit.h"
#include "slalom/mrpt_io/RawlogWriter.h"
#include "slalom/mrpt_io/VelodyneCapture.h"

namespace
{
using namespace slalom;

struct Options
{
  std::filesystem::path pcap, rawlog;
  std::string label = "VELODYNE";
  std::vector<double> mount;  ///< x y z [m] yaw pitch roll [deg]
  bool overwrite = false, quiet = false;
};

Eigen::Isometry3d mountOf(const std::vector<double>& m)
{
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  if (m.empty()) return T;
  if (m.size() != 3 && m.size() != 6)
    throw app::UsageError("--mount: expected x,y,z or x,y,z,yaw,pitch,roll");
  T.translation() = Eigen::Vector3d(m[0], m[1], m[2]);
  if (m.size() == 3) return T;
  constexpr double kDegree = std::numbers::pi / 180.0;
  T.linear() = (Eigen::AngleAxisd(m[3] * kDegree, Eigen::Vector3d::UnitZ()) *
                Eigen::AngleAxisd(m[4] * kDegree, Eigen::Vector3d::UnitY()) *
                Eigen::AngleAxisd(m[5] * kDegree, Eigen::Vector3d::UnitX()))
                   .toRotationMatrix();
  return T;
}

void tell(const mrpt_io::CaptureStatistics& s, const std::filesystem::path& rawlog)
{
  std::cout << rawlog.string() << ": " << s.scans << " scans of " << s.packets << " packets, "
            << s.fixes << " GPS observations of " << s.position_packets << " position packets\n";
  for (const auto& [reason, count] : s.skipped)
    std::cout << "skipped: " << count << " x " << reason << "\n";
}

int run(const Options& options)
{
  mrpt_io::limitMemory(std::uint64_t(4) << 30);
  if (!options.overwrite && std::filesystem::exists(options.rawlog))
    throw app::UsageError(options.rawlog.string() + " exists; -w replaces it");
  mrpt_io::VelodyneCapture capture(options.pcap,
                                   {.scan_label = options.label, .T_BS = mountOf(options.mount)});
  mrpt_io::RawlogWriter writer(options.rawlog);
  std::optional<mrpt_io::RawlogError> damage;
  const auto next = [&]() -> mrpt::obs::CObservation::Ptr
  {
    try
    {
      return capture.next();
    }
    catch (const mrpt_io::RawlogError& e)
    {
      damage = e;
      return nullptr;
    }
  };
  while (const auto observation = app::interrupted() ? nullptr : next()) writer.write(*observation);
  const mrpt_io::CaptureStatistics& statistics = capture.statistics();
  if (statistics.scans + statistics.fixes == 0)
    throw damage.value_or(
        mrpt_io::RawlogError(options.pcap.string() + ": no packet of a Velodyne sensor in it"));
  writer.close();
  if (!options.quiet) tell(statistics, options.rawlog);
  if (damage) throw *damage;
  return app::interrupted() ? app::kInterrupted : app::kDone;
}
}  // namespace

int main(int argc, char** argv)
{
  Options options;
  return app::runProgram(
      argc, argv, "slalom-import", "Turns a recording of another kind into a rawlog.",
      [&](CLI::App& app)
      {
        app.add_option("--pcap", options.pcap, "network capture of a Velodyne sensor")->required();
        app.add_option("--rawlog", options.rawlog, "rawlog to write")->required();
        app.add_option("--label", options.label, "sensor label of the scans")
            ->capture_default_str();
        app.add_option("--mount", options.mount,
                       "sensor on the vehicle: x,y,z[,yaw,pitch,roll] [m, deg]")
            ->delimiter(',')
            ->check(app::number(-1e4, 1e4))
            ->allow_extra_args(false);
        app.add_flag("-w,--overwrite", options.overwrite, "an existing rawlog may be replaced");
        app.add_flag("-q,--quiet", options.quiet, "print nothing but errors");
      },
      [&] { return run(options); });
}
