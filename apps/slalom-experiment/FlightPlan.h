// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "Experiment.h"

namespace slalom::experiment
{
/// One flight of slalom-fly.
struct PlannedFlight
{
  std::string group, name;  ///< `name` is unique within the experiment: GROUP/WORLD-...-sN
  std::string world;        ///< stem of the world's file
  std::uint64_t seed = 0;
  std::filesystem::path folder;        ///< of its output
  std::vector<std::string> arguments;  ///< of slalom-fly, without -o
  std::string key;                     ///< fingerprint of all that decides what is flown
};

/** All flights of the experiment, in order. Generated forests are written to `out`/worlds.
 *  @param out output folder of the experiment, absolute
 *  @param data folder of worlds that replace the shipped ones; empty = none
 *  @param program slalom-fly: another build of it is another flight
 *  @throws mrpt_io::ConfigError on a world or file that is not there, or two flights of one name */
[[nodiscard]] std::vector<PlannedFlight> planFlights(const Experiment& experiment,
                                                     const std::filesystem::path& out,
                                                     const std::filesystem::path& data,
                                                     const std::filesystem::path& program);

}  // namespace slalom::experiment
