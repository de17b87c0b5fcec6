// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace slalom::core
{
[[nodiscard]] std::string_view trimmed(std::string_view text);  ///< without blanks at its ends

/// A finite decimal number and nothing else.
[[nodiscard]] std::optional<double> parseNumber(std::string_view text);

/// One line of a table that holds data: trimmed fields and where they stand.
struct TextRow
{
  int line = 0;
  std::vector<std::string> fields;
};

/** Lines of a text table, without empty lines and `#` comments. `separator` 0 means runs of blanks.
 *  @throws std::runtime_error if the file cannot be read or is not text */
[[nodiscard]] std::vector<TextRow> readRows(const std::filesystem::path& file, char separator);

/// Field `index` of the row as a number. @throws std::runtime_error naming file, line, value
[[nodiscard]] double numberAt(const std::filesystem::path& file, const TextRow& row,
                              std::size_t index);

[[noreturn]] void failAt(const std::filesystem::path& file, int line, const std::string& what);

}  // namespace slalom::core
