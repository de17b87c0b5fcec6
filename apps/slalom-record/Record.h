// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>

#include "Program.h"

namespace slalom::record
{
struct Options
{
  app::CommonOptions common;
  std::filesystem::path world, trajectory, rawlog;
  std::filesystem::path make_forest;  ///< write a forest there instead of recording
  std::uint64_t seed = 1;
  std::optional<double> speed, acceleration;  ///< win over [flight]
  bool allow_collision = false;
};

/// Makes the forest or flies the script and records it. @return exit code
[[nodiscard]] int run(const Options& options);

}  // namespace slalom::record
