// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace slalom::mrpt_io
{
[[nodiscard]] bool sameIgnoringCase(std::string_view a, std::string_view b);

/// Letters inserted, removed, replaced or swapped with their neighbour to get from `a` to `b`,
/// ignoring case (optimal string alignment distance).
[[nodiscard]] std::size_t editDistance(std::string_view a, std::string_view b);

/// The candidate nearest to `word`, or "" when none is near enough to be a slip of the pen.
[[nodiscard]] std::string nearest(std::string_view word,
                                  const std::vector<std::string>& candidates);

/// "; did you mean 'x'?" or "".
[[nodiscard]] std::string didYouMean(std::string_view word,
                                     const std::vector<std::string>& candidates);

}  // namespace slalom::mrpt_io
