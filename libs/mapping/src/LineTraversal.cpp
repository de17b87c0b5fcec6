// SPDX-License-Identifier: BSD-3-Clause
#include "LineTraversal.h"

#include <algorithm>

namespace slalom::mapping::detail
{
namespace
{
namespace portable
{
#define SLALOM_SIMD_BYTES 16
#include "LineTraversalKernel.inl"
#undef SLALOM_SIMD_BYTES
}  // namespace portable

#if defined(__x86_64__)
#pragma GCC push_options
#pragma GCC target("avx2")
namespace avx2
{
#define SLALOM_SIMD_BYTES 32
#include "LineTraversalKernel.inl"
#undef SLALOM_SIMD_BYTES
}  // namespace avx2
#pragma GCC pop_options

#pragma GCC push_options
#pragma GCC target("avx512bw,avx512dq,avx512vl")
namespace avx512
{
#define SLALOM_SIMD_BYTES 64
#include "LineTraversalKernel.inl"
#undef SLALOM_SIMD_BYTES
}  // namespace avx512
#pragma GCC pop_options
#endif

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
