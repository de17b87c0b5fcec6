// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <string>
#include <string_view>

namespace slalom::mrpt_io::detail
{
[[nodiscard]] std::string_view trim(std::string_view text);

/// The text before a comment: `//`, `#` or `;` at its beginning or after a blank.
[[nodiscard]] std::string_view withoutComment(std::string_view text);

/// One `key = value` with its place, definitions expanded.
struct IniEntry
{
  std::string section, key, value, origin;
};

/** Walks INI text line by line and hands over every entry and every section.
 *  @throws ConfigError naming `name` and the line */
void parseIni(std::string_view text, std::string_view name,
              const std::function<void(const std::string& section)>& on_section,
              const std::function<void(IniEntry entry)>& on_entry);

}  // namespace slalom::mrpt_io::detail
