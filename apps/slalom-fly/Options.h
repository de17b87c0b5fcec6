// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "Program.h"

namespace slalom::fly
{
struct Options
{
  app::CommonOptions common;
  std::filesystem::path world;
  std::string start, goal;          ///< x,y,z
  std::filesystem::path waypoints;  ///< on the way to the goal; without --goal the last is the goal
  std::uint64_t seed = 1;
  std::string vehicle_state;           ///< empty: [state] source; truth or estimate
  std::optional<double> time_limit_s;  ///< wins over [fly] time_limit_s
  std::filesystem::path record;        ///< rawlog to write
};

}  // namespace slalom::fly
