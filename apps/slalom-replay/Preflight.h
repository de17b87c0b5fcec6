// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "slalom/engine/EngineConfig.h"

namespace slalom::replay
{
/// What the first seconds of a recording promise.
struct Preflight
{
  std::map<std::string, std::uint64_t> observations;  ///< class -> count, in the seconds looked at
  std::uint64_t position_fixes = 0;
  bool volumetric_range = false;  ///< a 3-D range sensor
  bool planar_range = false;      ///< a 2-D laser
  bool imu = false, poses = false, odometry = false, truth = false;

  [[nodiscard]] engine::StateSourceKind bestSource() const;
};

/** Looks at the first `seconds` of log time (and at least at the first range scan, if one comes
 * within ten times that).
 *  @throws mrpt_io::RawlogError if the file is no rawlog, or holds nothing that could be a flight;
 * the message says what is in it instead */
[[nodiscard]] Preflight inspect(const std::filesystem::path& rawlog, const std::string& truth_label,
                                double seconds);

}  // namespace slalom::replay
