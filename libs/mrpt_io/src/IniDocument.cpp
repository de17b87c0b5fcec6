// SPDX-License-Identifier: BSD-3-Clause
#include "slalom/mrpt_io/IniDocument.h"

#include <mrpt/config/CConfigFileBase.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <sstream>

#include "IniParser.h"

namespace slalom::mrpt_io
{
namespace
{
constexpr std::uintmax_t kLargestFile = 1 << 22;  // a configuration is text that a person wrote
}

bool IniDocument::CaseInsensitive::operator()(std::string_view a, std::string_view b) const
{
  const auto less = [](char x, char y)
  {
    return std::tolower(static_cast<unsigned char>(x)) <
           std::tolower(static_cast<unsigned char>(y));
  };
  return std::lexicographical_compare(a.begin(), a.end(), b.begin(), b.end(), less);
}

IniDocument IniDocument::read(const std::filesystem::path& file)
{
  std::error_code error;
  if (!std::filesystem::exists(file, error))
    throw ConfigError(file.string() + ": no such configuration file");
  if (!std::filesystem::is_regular_file(file, error) && !std::filesystem::is_fifo(file, error))
    throw ConfigError(file.string() + ": not a file");
  if (const auto size = std::filesystem::file_size(file, error); !error && size > kLargestFile)
    throw ConfigError(file.string() + ": " + std::to_string(size) +
                      " bytes; not a configuration file");
  std::ifstream stream(file, std::ios::binary);
  std::ostringstream text;
  if (stream) text << stream.rdbuf();
  // operator<<(streambuf*) marks an empty source as failure of the sink only.
  if (!stream.is_open() || stream.bad())
    throw ConfigError(file.string() + ": cannot be read: " + std::strerror(errno));
  return parse(text.str(), file.string());
}

IniDocument IniDocument::parse(std::string_view text, std::string_view name)
{
  IniDocument document;
  const auto onSection = [&](const std::string& section) { document.values_[section]; };
  const auto onEntry = [&](detail::IniEntry entry)
  {
    auto& section = document.values_[entry.section];
    if (const auto before = section.find(entry.key); before != section.end())
      throw ConfigError(entry.origin + ": [" + entry.section + "] " + entry.key +
                        " was already set at " + before->second.origin);
    section[entry.key] = {std::move(entry.value), std::move(entry.origin)};
  };
  detail::parseIni(text, name, onSection, onEntry);
  return document;
}

IniDocument IniDocument::from(const mrpt::config::CConfigFileBase& source, std::string_view name)
{
  IniDocument document;
  std::vector<std::string> sections, keys;
  source.getAllSections(sections);
  for (const std::string& section : sections)
  {
    auto& values = document.values_[section];
    source.getAllKeys(section, keys);
    for (const std::string& key : keys)
      values[key] = {source.read_string(section, key, ""), std::string(name)};
  }
  return document;
}

void IniDocument::overlay(const IniDocument& over)
{
  for (const auto& [section, keys] : over.values_)
  {
    auto& mine = values_[section];
    for (const auto& [key, value] : keys) mine.insert_or_assign(key, value);
  }
}

void IniDocument::set(std::string_view assignment)
{
  const std::size_t equal = assignment.find('=');
  const std::size_t dot = assignment.substr(0, equal).find('.');
  if (equal == std::string_view::npos || dot == std::string_view::npos)
    throw ConfigError("--set " + std::string(assignment) + ": expected section.key=value");
  const std::string section(detail::trim(assignment.substr(0, dot)));
  const std::string key(detail::trim(assignment.substr(dot + 1, equal - dot - 1)));
  const std::string_view value = detail::trim(assignment.substr(equal + 1));
  if (section.empty() || key.empty())
    throw ConfigError("--set " + std::string(assignment) + ": section or key is empty");
  // Such a value could not be written to effective.ini and read back.
  if (value.find_first_of(std::string_view("\n\r\0", 3)) != std::string_view::npos ||
      detail::withoutComment(value).size() != value.size() || value.ends_with('\\'))
    throw ConfigError("--set " + section + "." + key +
                      ": the value holds a comment or a line break");
  values_[section].insert_or_assign(key, Value{std::string(value), "--set"});
}

const IniDocument::Value* IniDocument::find(std::string_view section, std::string_view key) const
{
  const auto s = values_.find(section);
  if (s == values_.end()) return nullptr;
  const auto k = s->second.find(key);
  return k == s->second.end() ? nullptr : &k->second;
}

std::vector<std::string> IniDocument::sections() const
{
  std::vector<std::string> names;
  for (const auto& [section, keys] : values_) names.push_back(section);
  return names;
}

std::vector<std::string> IniDocument::keys(std::string_view section) const
{
  std::vector<std::string> names;
  if (const auto found = values_.find(section); found != values_.end())
    for (const auto& [key, value] : found->second) names.push_back(key);
  return names;
}

void IniDocument::copyTo(mrpt::config::CConfigFileBase& target) const
{
  for (const auto& [section, keys] : values_)
    for (const auto& [key, value] : keys) target.write(section, key, value.text);
}

}  // namespace slalom::mrpt_io
