// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <limits>

#include "Program.h"

namespace slalom::replay
{
struct Options
{
  app::CommonOptions common;
  std::filesystem::path rawlog;
  std::filesystem::path mission;  ///< waypoint file; empty: [replay] mission, or none
  std::filesystem::path verify;   ///< folder of an earlier run to compare with
  double start_s = 0.0;
  double duration_s = std::numeric_limits<double>::infinity();
  double rate = 0.0;  ///< times real time; 0: as fast as possible
  bool threaded = false;
  bool dry_run = false;
};

}  // namespace slalom::replay
