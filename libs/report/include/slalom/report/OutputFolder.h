// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>

#include "slalom/report/AtomicFile.h"

namespace slalom::report
{
/** Makes `folder` ready for a new report: creates it, or, if it holds an earlier report and
 * `overwrite` is set, removes exactly the files that a report consists of (cycle pictures of a
 * longer earlier run included). Foreign files are left alone.
 *
 *  @throws OutputError when the folder holds an earlier report and `overwrite` is not set, when it
 * is not a folder, or when it cannot be created or written to */
void prepareOutputFolder(const std::filesystem::path& folder, bool overwrite);

}  // namespace slalom::report
