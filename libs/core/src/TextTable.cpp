// SPDX-License-Identifier: BSD-3-Clause
#include "slalom/core/TextTable.h"

#include <charconv>
#include <cmath>
#include <fstream>
#include <stdexcept>

namespace slalom::core
{
std::string_view trimmed(std::string_view text)
{
  constexpr std::string_view kBlanks = " \t\r";
  const std::size_t first = text.find_first_not_of(kBlanks);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kBlanks) - first + 1);
}

namespace
{
std::vector<std::string> split(std::string_view text, char separator)
{
  std::vector<std::string> fields;
  while (true)
  {
    const std::size_t end = separator ? text.find(separator) : text.find_first_of(" \t");
    fields.emplace_back(trimmed(text.substr(0, end)));
    if (end == std::string_view::npos) return fields;
    text = text.substr(end + 1);
    if (!separator) text = trimmed(text);
  }
}
}  // namespace

std::optional<double> parseNumber(std::string_view text)
{
  if (text.starts_with('+')) text.remove_prefix(1);
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size() || !std::isfinite(value))
    return std::nullopt;
  return value;
}

std::vector<TextRow> readRows(const std::filesystem::path& file, char separator)
{
  std::ifstream stream(file, std::ios::binary);
  if (!stream) throw std::runtime_error(file.string() + ": cannot be read");
  std::vector<TextRow> rows;
  std::string text;
  for (int line = 1; std::getline(stream, text); ++line)
  {
    if (text.find('\0') != std::string::npos) failAt(file, line, "not a text file");
    const std::string_view content = trimmed(text);
    if (content.empty() || content.front() == '#') continue;
    rows.push_back({line, split(content, separator)});
  }
  if (stream.bad()) throw std::runtime_error(file.string() + ": cannot be read");
  return rows;
}

double numberAt(const std::filesystem::path& file, const TextRow& row, std::size_t index)
{
  if (index >= row.fields.size())
    failAt(file, row.line, "field " + std::to_string(index + 1) + " is missing");
  const std::optional<double> value = parseNumber(row.fields[index]);
  if (!value)
    failAt(file, row.line, "'" + row.fields[index].substr(0, 40) + "' is not a finite number");
  return *value;
}

void failAt(const std::filesystem::path& file, int line, const std::string& what)
{
  throw std::runtime_error(file.string() + ":" + std::to_string(line) + ": " + what);
}

}  // namespace slalom::core
