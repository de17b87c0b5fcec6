// SPDX-License-Identifier: BSD-3-Clause
#include "System.h"

#include <mrpt/system/os.h>
#include <sys/sysinfo.h>

#include <string>
#include <thread>

namespace slalom::doctor
{
namespace
{
using mrpt_io::Finding;
using mrpt_io::Severity;

constexpr double kLittleMemory = 1.0;  // [GiB]

Finding build()
{
  const std::string text =
      "slalom " SLALOM_VERSION ", build type " SLALOM_BUILD_TYPE ", compiler g++ " __VERSION__;
#ifdef __OPTIMIZE__
  return {Severity::Ok, text};
#else
  return {Severity::Warning, text + ": not optimised, expect it to be ten times slower"};
#endif
}

/// Libraries that the build found; MRPT tells itself which one is loaded.
void libraries(std::vector<Finding>& out)
{
  out.push_back({Severity::Ok, mrpt::system::MRPT_getVersion()});
  const std::pair<std::string, std::string> built_with[] = {{"OctoMap", SLALOM_OCTOMAP_VERSION},
                                                            {"NLopt", SLALOM_NLOPT_VERSION},
                                                            {"Ipopt", SLALOM_IPOPT_VERSION},
                                                            {"OpenCV", SLALOM_OPENCV_VERSION},
                                                            {"Eigen", SLALOM_EIGEN_VERSION}};
  for (const auto& [name, version] : built_with)
    out.push_back({version.empty() ? Severity::Warning : Severity::Ok,
                   name + " " + (version.empty() ? "of unknown version" : version)});
}

Finding memory()
{
  struct sysinfo info
  {
  };
  if (::sysinfo(&info) != 0) return {Severity::Warning, "memory: unknown"};
  constexpr double kGib = 1024.0 * 1024.0 * 1024.0;
  const double total = static_cast<double>(info.totalram) * info.mem_unit / kGib;
  const std::string text = "memory: " + std::to_string(static_cast<int>(total * 10.0) / 10) + "." +
                           std::to_string(static_cast<int>(total * 10.0) % 10) + " GiB";
  return {total < kLittleMemory ? Severity::Warning : Severity::Ok, text};
}

Finding processor()
{
  const unsigned cores = std::thread::hardware_concurrency();
  std::string text = "processor: " + std::to_string(cores) + " cores";
#if defined(__x86_64__)
  text += __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") ? ", AVX2 and FMA"
                                                                          : ", without AVX2";
#endif
  return {cores > 1 ? Severity::Ok : Severity::Warning, text};
}
}  // namespace

std::vector<Finding> examineSystem()
{
  std::vector<Finding> findings{build()};
  libraries(findings);
  findings.push_back(processor());
  findings.push_back(memory());
  return findings;
}

}  // namespace slalom::doctor
