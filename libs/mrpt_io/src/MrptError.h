// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <exception>
#include <string>

namespace slalom::mrpt_io::detail
{
/// The message of an MRPT exception without its location and call stack.
[[nodiscard]] inline std::string mrptMessage(const std::exception& e)
{
  const std::string text = e.what();
  constexpr std::string_view kMark = "Message:";
  std::size_t begin = text.find(kMark);
  begin = begin == std::string::npos ? 0 : text.find_first_not_of(' ', begin + kMark.size());
  if (begin == std::string::npos) return "unknown error";
  return text.substr(begin, text.find('\n', begin) - begin);
}

}  // namespace slalom::mrpt_io::detail
