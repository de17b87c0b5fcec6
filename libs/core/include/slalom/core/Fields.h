// SPDX-License-Identifier: BSD-3-Clause
/** Vocabulary with which a config struct describes its own fields.
 *
 *  A config struct lists its fields once, in `template <class Self, class Visit> static void
 * fields(Self&, Visit&&)`. Loading, saving, documentation and tests all walk that one list; an
 * absent key keeps the struct's default.
 *
 *  A visitor is called as v(name, value&, Range, help[, Level]) for double and int,
 *  v(name, value&, help[, Level]) for bool, std::string and Eigen::Vector3d, and
 *  v(name, value&, Names<E>, help[, Level]) for enums.
 */
#pragma once

#include <limits>
#include <string_view>
#include <utility>
#include <vector>

namespace slalom::core
{
/// Closed interval of allowed values, in the unit of the field.
struct Range
{
  double min = -std::numeric_limits<double>::infinity();
  double max = std::numeric_limits<double>::infinity();
};

/// Spelling of each enumerator in INI files.
template <class E>
using Names = std::vector<std::pair<std::string_view, E>>;

/// Public keys are the few that a user is expected to set; expert keys are documented apart.
enum class Level
{
  Public,
  Expert
};

}  // namespace slalom::core
