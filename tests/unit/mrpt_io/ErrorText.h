// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace slalom::test
{
/// The message of the E that `action` throws; "(no error)" if it throws none.
template <class E, class Action>
[[nodiscard]] std::string errorText(Action action)
{
  try
  {
    action();
  }
  catch (const E& e)
  {
    return e.what();
  }
  return "(no error)";
}

}  // namespace slalom::test
