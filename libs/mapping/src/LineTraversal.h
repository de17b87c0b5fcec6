// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "InstructionSet.h"

namespace slalom::mapping::detail
{
/** A line through a grid of bytes, ready to be traversed cell by cell (Amanatides and Woo, 1987).
 *
 *  `next[a]` is where the line enters the next cell along axis a, advanced by `gap[a]` per cell;
 * both in metres along the line. Positions are offsets into the grid. */
struct GridLine
{
  double next[3], gap[3];
  double length;
  std::int64_t stride[3];
  std::int64_t from, to;
  int steps;  ///< cell borders between the ends
};

/// Most steps of a line; longer ones take another path.
inline constexpr int kMaxSteps = 4000;

/** Sets `bit` in every cell of the lines but the last, several lines at a time: the axis of each
 * step is a coin toss for the branch predictor, so the steps are made without branches.
 *
 *  Ends like OctoMap's rays do: in the last cell, or where rounding has missed it and the next
 * border is past the end. Lines must stay inside the grid.
 *  @param spare offset of a byte that may be overwritten */
void traverse(const std::vector<GridLine>& lines, std::uint8_t bit, std::uint8_t* grid,
              std::int64_t spare, InstructionSet set = bestInstructionSet());

}  // namespace slalom::mapping::detail
