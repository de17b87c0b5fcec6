// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "BoxSearch.h"

namespace slalom::optim::detail
{
/** Brings `best` (evaluated at the start) near the minimum of a cost with soft limits by a
 * primal-dual interior point.
 *
 *  A soft limit w (|d| - L)_+^2 is w (d - p)^2 minimised over |p| <= L, so without kinks, with p
 * another variable in a box; p is eliminated row by row, and what remains is banded. There is no
 * line search: only better points are kept, and the caller finishes with a globalised method.
 * @return false if the search must end (best.termination and message say why) */
[[nodiscard]] bool approach(const BoxProblem& problem, LimitedCost& cost, BoxResult& best);

}  // namespace slalom::optim::detail
