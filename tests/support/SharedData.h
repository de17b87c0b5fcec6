// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdlib>
#include <filesystem>

namespace slalom::test
{
/** A file of the evaluation data that lies beside the source tree (or where SLALOM_SHARED_DATA
 * says). It is not part of the repository: a test whose file is absent skips itself, `if
 * (!exists(file)) GTEST_SKIP() << file;`. */
[[nodiscard]] inline std::filesystem::path sharedData(const std::filesystem::path& relative)
{
  const char* given = std::getenv("SLALOM_SHARED_DATA");
  const std::filesystem::path root =
      given ? std::filesystem::path(given)
            : std::filesystem::path(SLALOM_SOURCE_DIR) / "../shared/data";
  return root / relative;
}

}  // namespace slalom::test
