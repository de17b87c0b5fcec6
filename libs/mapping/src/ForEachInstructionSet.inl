// SPDX-License-Identifier: BSD-3-Clause
// Compiles the kernel file SLALOM_KERNEL once per InstructionSet, each into a namespace of its own. Include it inside an
// anonymous namespace.
namespace portable
{
#define SLALOM_SIMD_BYTES 16
#include SLALOM_KERNEL
#undef SLALOM_SIMD_BYTES
}  // namespace portable

#if defined(__x86_64__)
#pragma GCC push_options
#pragma GCC target("avx2")
namespace avx2
{
#define SLALOM_SIMD_BYTES 32
#include SLALOM_KERNEL
#undef SLALOM_SIMD_BYTES
}  // namespace avx2
#pragma GCC pop_options

#pragma GCC push_options
#pragma GCC target("avx512bw,avx512dq,avx512vl")
namespace avx512
{
#define SLALOM_SIMD_BYTES 64
#include SLALOM_KERNEL
#undef SLALOM_SIMD_BYTES
}  // namespace avx512
#pragma GCC pop_options
#endif
