// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <string>

namespace slalom::mrpt_io::detail
{
/// What was not used, by reason.
using Dropped = std::map<std::string, std::uint64_t>;
}  // namespace slalom::mrpt_io::detail
