// SPDX-License-Identifier: BSD-3-Clause
// Values of config fields as text and back.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <string_view>

#include "slalom/core/Fields.h"

namespace slalom::mrpt_io::detail
{
/// Shortest text that reads back to the same double.
[[nodiscard]] std::string toText(double value);
[[nodiscard]] std::string toText(const Eigen::Vector3d& value);
[[nodiscard]] std::string toText(const core::Range& range);

/// The whole text as one finite number; nothing else is accepted.
[[nodiscard]] std::optional<double> toNumber(std::string_view text);
[[nodiscard]] std::optional<int> toInteger(std::string_view text);
[[nodiscard]] std::optional<bool> toFlag(std::string_view text);
[[nodiscard]] std::optional<Eigen::Vector3d> toVector(std::string_view text);

}  // namespace slalom::mrpt_io::detail
