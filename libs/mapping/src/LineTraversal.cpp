// SPDX-License-Identifier: BSD-3-Clause
#include "LineTraversal.h"

#include <algorithm>

namespace slalom::mapping::detail
{
namespace
{
#define SLALOM_KERNEL "LineTraversalKernel.inl"
#include "ForEachInstructionSet.inl"
#undef SLALOM_KERNEL

using Traverse = void (*)(const GridLine* const*, std::size_t, std::uint8_t, std::uint8_t*,
                          std::int64_t);

Traverse traverseFor([[maybe_unused]] InstructionSet set)
{
#if defined(__x86_64__)
  if (set == InstructionSet::Avx512) return &avx512::traverseAll;
  if (set == InstructionSet::Avx2) return &avx2::traverseAll;
#endif
  return &portable::traverseAll;
}

}  // namespace

void traverse(const std::vector<GridLine>& lines, std::uint8_t bit, std::uint8_t* grid,
              std::int64_t spare, InstructionSet set)
{
  // By length (a counting sort), so that the lines of a group end together.
  int longest = 0;
  for (const GridLine& line : lines) longest = std::max(longest, line.steps);
  std::vector<std::uint32_t> first(longest + 2, 0);
  for (const GridLine& line : lines) ++first[line.steps + 1];
  for (int i = 1; i <= longest; ++i) first[i] += first[i - 1];
  std::vector<const GridLine*> sorted(lines.size());
  for (const GridLine& line : lines) sorted[first[line.steps]++] = &line;
  traverseFor(set)(sorted.data(), sorted.size(), bit, grid, spare);
}

}  // namespace slalom::mapping::detail
