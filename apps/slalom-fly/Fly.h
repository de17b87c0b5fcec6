// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "Options.h"

namespace slalom::fly
{
/// Flies and writes the report. @return exit code
[[nodiscard]] int run(const Options& options);

}  // namespace slalom::fly
