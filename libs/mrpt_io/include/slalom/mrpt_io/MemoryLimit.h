// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

namespace slalom::mrpt_io
{
/** Caps the address space of this process, so that a damaged length field in an uncompressed rawlog
 * (which has no checksum; MRPT allocates before it reads) ends in RawlogError instead of an
 * exhausted machine. A smaller limit that is already in force stays. For programs, at their start.
 *  @return false when the system refuses */
bool limitMemory(std::uint64_t bytes);

}  // namespace slalom::mrpt_io
