// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstring>

#include "TrackingWork.h"

namespace slalom::optim::detail
{
namespace
{
namespace portable
{
#define SLALOM_SIMD_BYTES 16
#include "TrackingVariants.inl"
#undef SLALOM_SIMD_BYTES
}  // namespace portable

#if defined(__x86_64__)
#pragma GCC push_options
#pragma GCC target("avx2")
namespace avx2
{
#define SLALOM_SIMD_BYTES 32
#include "TrackingVariants.inl"
#undef SLALOM_SIMD_BYTES
}  // namespace avx2
#pragma GCC pop_options
#endif

}  // namespace

InstructionSet bestInstructionSet()
{
#if defined(__x86_64__)
  static const bool avx2 = __builtin_cpu_supports("avx2");
  return avx2 ? InstructionSet::Avx2 : InstructionSet::Portable;
#else
  return InstructionSet::Portable;
#endif
}

template <>
TrackingSteps<1> trackingSteps<1>([[maybe_unused]] InstructionSet set, bool lag)
{
#if defined(__x86_64__)
  if (set == InstructionSet::Avx2) return lag ? avx2::heading_lag::kSteps : avx2::heading::kSteps;
#endif
  return lag ? portable::heading_lag::kSteps : portable::heading::kSteps;
}

template <>
TrackingSteps<3> trackingSteps<3>([[maybe_unused]] InstructionSet set, bool lag)
{
#if defined(__x86_64__)
  if (set == InstructionSet::Avx2) return lag ? avx2::flight_lag::kSteps : avx2::flight::kSteps;
#endif
  return lag ? portable::flight_lag::kSteps : portable::flight::kSteps;
}

}  // namespace slalom::optim::detail
