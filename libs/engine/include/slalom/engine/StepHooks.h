// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>

namespace slalom::local_planner
{
struct LocalPlannerInput;
}

namespace slalom::engine
{
/** Called just before a step, in the thread of that step, for tests that break things: a hook may
 * take its time, or throw (the step is then one that failed), or change what the local planner is
 * handed. Empty hooks, the normal case, cost nothing. */
struct StepHooks
{
  std::function<void()> map, global;
  std::function<void(local_planner::LocalPlannerInput& input)> local;
};

}  // namespace slalom::engine
