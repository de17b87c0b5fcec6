// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "Update.h"
#include "slalom/core/Measurements.h"

namespace slalom::estimation::detail
{
/// Why a measurement cannot be used ("non_finite", "out_of_range", "bad_sigma"); nullptr if it can.
[[nodiscard]] const char* defect(const core::ImuSample& sample);
[[nodiscard]] const char* defect(const core::PositionFix& fix);
[[nodiscard]] const char* defect(const core::VelocityFix& fix);
[[nodiscard]] const char* defect(const core::YawFix& fix);
[[nodiscard]] const char* defect(const core::PoseFix& fix);

/// The common shape of sound measurements; a standard deviation of zero becomes a millimetre,
/// millimetre per second or milliradian.
[[nodiscard]] Aid toAid(const core::PositionFix& fix, int slot);
[[nodiscard]] Aid toAid(const core::VelocityFix& fix, int slot);
[[nodiscard]] Aid toAid(const core::YawFix& fix, int slot);
[[nodiscard]] Aid toAid(const core::PoseFix& fix, int slot);

}  // namespace slalom::estimation::detail
