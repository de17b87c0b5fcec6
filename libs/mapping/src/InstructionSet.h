// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

namespace slalom::mapping::detail
{
/// What the vector kernels are compiled for. All of them give the same results to the last bit.
enum class InstructionSet
{
  Portable,
  Avx2,
  Avx512
};

/// Those that this processor has, best last.
[[nodiscard]] inline std::vector<InstructionSet> instructionSets()
{
  std::vector<InstructionSet> sets{InstructionSet::Portable};
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx2")) sets.push_back(InstructionSet::Avx2);
  if (__builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512dq") &&
      __builtin_cpu_supports("avx512vl"))
    sets.push_back(InstructionSet::Avx512);
#endif
  return sets;
}

[[nodiscard]] inline InstructionSet bestInstructionSet()
{
  static const InstructionSet best = instructionSets().back();
  return best;
}

}  // namespace slalom::mapping::detail
