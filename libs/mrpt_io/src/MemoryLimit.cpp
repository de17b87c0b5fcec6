// SPDX-License-Identifier: BSD-3-Clause
#include "slalom/mrpt_io/MemoryLimit.h"

#include <sys/resource.h>

namespace slalom::mrpt_io
{
bool limitMemory(std::uint64_t bytes)
{
  rlimit limit{};
  if (::getrlimit(RLIMIT_AS, &limit) != 0) return false;
  if (limit.rlim_cur != RLIM_INFINITY && limit.rlim_cur <= bytes) return true;
  limit.rlim_cur = bytes;
  return ::setrlimit(RLIMIT_AS, &limit) == 0;
}

}  // namespace slalom::mrpt_io
