// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "slalom/core/HalfSpaces.h"

namespace slalom::optim
{
/// Per point of a path the sets that must hold it, not owned; either empty or one entry per point.
/// A point may have no set, or several (a joint of two polyhedra).
using PathSets = std::vector<std::vector<const core::HalfSpaces*>>;

}  // namespace slalom::optim
