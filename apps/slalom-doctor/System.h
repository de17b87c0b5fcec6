// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "slalom/mrpt_io/Diagnosis.h"

namespace slalom::doctor
{
/// This build, its libraries, and the machine it runs on.
[[nodiscard]] std::vector<mrpt_io::Finding> examineSystem();

}  // namespace slalom::doctor
