// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "Flight.h"
#include "Refinements.h"
#include "slalom/core/CycleRecord.h"
#include "slalom/local_planner/LocalPlanner.h"

namespace slalom::engine
{
/// The plan that the local planner follows, from its progress on. @param ahead_s how much of it
void describePlan(const local_planner::LocalPlannerInput& input, double ahead_s,
                  core::CycleRecord& record);

/// What the local planner made of it; takes the vectors of `output`.
void describeStep(local_planner::LocalPlannerOutput& output, core::CycleRecord& record);

/// R and where the vehicle is on it, and how the plan in force came about.
void describeMission(const Flight& flight, const Refinements& refinements, double on_reference,
                     core::CycleRecord& record);

}  // namespace slalom::engine
