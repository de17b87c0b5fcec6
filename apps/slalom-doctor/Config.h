// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "slalom/mrpt_io/Diagnosis.h"

namespace slalom::doctor
{
/** What is wrong with the configuration of a replay: syntax, keys, ranges, rules between keys, and
 * the mission file it names.
 *  @param files later ones win, as for slalom-replay
 *  @param assignments "section.key=value", win over files */
[[nodiscard]] std::vector<mrpt_io::Finding> examineConfig(
    const std::vector<std::string>& files, const std::vector<std::string>& assignments);

/// docs/configuration.md: every key of every program.
[[nodiscard]] std::string configReference();

}  // namespace slalom::doctor
