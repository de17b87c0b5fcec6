// SPDX-License-Identifier: BSD-3-Clause
/** What programs that make something from input files share: inputs that are at fault, outputs that
 * are in the way. */
#pragma once

#include <filesystem>
#include <stdexcept>
#include <string>

#include "Program.h"
#include "slalom/core/Files.h"

namespace slalom::app
{
/// The input is at fault, not the program. Exit code 3.
class InputError : public std::runtime_error
{
 public:
  using std::runtime_error::runtime_error;
};

/// What `load` returns. @throws InputError for what it throws
template <class Load>
auto loaded(Load&& load)
{
  try
  {
    return load();
  }
  catch (const std::runtime_error& error)
  {
    throw InputError(error.what());
  }
}

/// @throws UsageError if the file is there and may not be replaced
inline void refuseExisting(const std::filesystem::path& file, bool overwrite)
{
  if (!core::mayBeReplaced(file))
    throw UsageError(file.string() + " is in the way: not a regular file");
  if (!overwrite && std::filesystem::exists(file))
    throw UsageError(file.string() + " exists; -w replaces it");
}

}  // namespace slalom::app
