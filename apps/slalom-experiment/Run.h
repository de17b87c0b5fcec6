// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "Options.h"

namespace slalom::experiment
{
/** Flies what is not flown yet, reads all, writes the tables.
 *  @return app::ExitCode: kDone if all acceptance numbers are met and nothing is missing,
 * kGoalNotReached if not, kInterrupted after Ctrl-C */
[[nodiscard]] int run(const Options& options);

}  // namespace slalom::experiment
