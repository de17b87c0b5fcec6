// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "slalom/report/FlightMetrics.h"
#include "slalom/report/RunInfo.h"

namespace slalom::report::detail
{
/// Text of metrics.json, schema_version 1: every number finite or null, units in the keys.
[[nodiscard]] std::string metricsJson(const FlightMetrics& metrics, const RunInfo& info,
                                      const RunSummary& summary);

}  // namespace slalom::report::detail
