// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>

#include "Program.h"

namespace slalom::experiment
{
/// The command line of slalom-experiment.
struct Options
{
  app::CommonOptions common;
  std::string experiment;      ///< e1, e2, e3, e4, gallery, soak, or an INI file
  int jobs = 1;                ///< flights at a time
  std::filesystem::path data;  ///< folder of worlds that replace the shipped ones
  std::string only;            ///< groups to fly, separated by commas; empty = all
  bool dry_run = false;        ///< list the flights and stop
};

}  // namespace slalom::experiment
