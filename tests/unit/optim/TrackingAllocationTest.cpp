// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <atomic>
#include <cerrno>
#include <cstdlib>
#include <memory>

#include "TrackingProblems.h"

// Eigen asks malloc, not operator new, so malloc itself is counted, in the whole test program. The
// sanitizers want it for themselves.
#if defined(__GLIBC__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define SLALOM_COUNTS_MALLOC 1
#else
#define SLALOM_COUNTS_MALLOC 0
#endif

namespace
{
std::atomic<long> allocations{0};
}

#if SLALOM_COUNTS_MALLOC
extern "C"
{
  void* __libc_malloc(std::size_t);
  void* __libc_calloc(std::size_t, std::size_t);
  void* __libc_realloc(void*, std::size_t);
  void* __libc_memalign(std::size_t, std::size_t);

  void* malloc(std::size_t size)
  {
    ++allocations;
    return __libc_malloc(size);
  }
  void* calloc(std::size_t count, std::size_t size)
  {
    ++allocations;
    return __libc_calloc(count, size);
  }
  void* realloc(void* memory, std::size_t size)
  {
    ++allocations;
    return __libc_realloc(memory, size);
  }
  void* aligned_alloc(std::size_t alignment, std::size_t size)
  {
    ++allocations;
    return __libc_memalign(alignment, size);
  }
  int posix_memalign(void** memory, std::size_t alignment, std::size_t size)
  {
    ++allocations;
    *memory = __libc_memalign(alignment, size);
    return *memory == nullptr ? ENOMEM : 0;
  }
}
#endif

namespace
{
using namespace slalom::optim;
using slalom::core::Deadline;
using slalom::core::Rng;
using slalom::test::WildTracking;

template <int D>
void expectNoAllocation(const TrackingSolverConfig& config)
{
  const auto solver = makeTrackingSolver<D>(config, 20, 8);
  for (int seed = 0; seed < 200; ++seed)
  {
    SCOPED_TRACE(seed);
    Rng rng(static_cast<std::uint64_t>(90000 + seed));
    WildTracking<D> wild(rng, 20, 8);
    // Every way a solve can end: optimal, clash, refused, late, early.
    if (seed % 10 == 1) wild.qp.u_before *= 3.0;
    if (seed % 10 == 2) wild.qp.p[0] = std::nan("");
    const Deadline deadline =
        seed % 10 == 3 ? Deadline::in(std::chrono::nanoseconds(0)) : Deadline::none();
    const long before = allocations;
    (void)solver->solve(wild.qp, wild.guess, deadline);
    EXPECT_EQ(allocations, before);
  }
}

TEST(TrackingAllocation, TheFastBackEndNeedsNoMemoryToSolve)
{
  if (!SLALOM_COUNTS_MALLOC) GTEST_SKIP() << "malloc belongs to the sanitizer here";
  long before = allocations;
  const auto by_new = std::make_unique<double[]>(100);
  const auto by_aligned_new = std::make_unique<Eigen::Vector4d[]>(100);
  // Memory whose address nobody sees need not be asked for.
  const void* volatile seen = by_new.get();
  seen = by_aligned_new.get();
  ASSERT_NE(seen, nullptr);
  ASSERT_EQ(allocations, before + 2) << "the counter does not count";
  before = allocations;
  const Eigen::VectorXd by_eigen(static_cast<Eigen::Index>(allocations % 7 + 100));
  ASSERT_EQ(allocations, before + 1) << "the counter does not count";
  expectNoAllocation<1>({});
  expectNoAllocation<3>({});
  expectNoAllocation<3>({.max_iterations = 2});
}

}  // namespace
