// SPDX-License-Identifier: BSD-3-Clause
#include "slalom/mrpt_io/MemoryLimit.h"

#include <sys/resource.h>

namespace slalom::mrpt_io
{
bool limitMemory(std::uint64_t bytes)
{
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  (void)bytes;
  return false;  // the shadow memory of a sanitizer needs the whole address space
#else
  rlimit limit{};
  if (::getrlimit(RLIMIT_AS, &limit) != 0) return false;
  if (limit.rlim_cur != RLIM_INFINITY && limit.rlim_cur <= bytes) return true;
  limit.rlim_cur = bytes;
  return ::setrlimit(RLIMIT_AS, &limit) == 0;
#endif
}

}  // namespace slalom::mrpt_io
