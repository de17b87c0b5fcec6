// SPDX-License-Identifier: BSD-3-Clause
#include "IniParser.h"

#include <cctype>
#include <map>
#include <vector>

#include "slalom/mrpt_io/IniDocument.h"
#include "slalom/mrpt_io/Spelling.h"

namespace slalom::mrpt_io::detail
{
namespace
{
bool isBlank(char c)
{
  return std::isspace(static_cast<unsigned char>(c)) != 0;
}

class Parser
{
 public:
  explicit Parser(std::string_view name) : name_(name) {}

  void line(std::string_view raw, const std::function<void(const std::string&)>& on_section,
            const std::function<void(IniEntry)>& on_entry)
  {
    const std::string_view text = trim(raw);
    if (text.empty()) return;
    if (text.front() == '[')
      on_section(section_ = sectionName(text));
    else if (text.front() == '@')
      define(text);
    else
      on_entry(entry(text));
  }
  void setLine(int number) { line_ = number; }
  [[noreturn]] void fail(const std::string& what) const
  {
    throw ConfigError(place() + ": " + what);
  }

 private:
  std::string place() const { return name_ + ":" + std::to_string(line_); }

  std::string sectionName(std::string_view text) const
  {
    const std::string_view inner =
        text.back() == ']' ? trim(text.substr(1, text.size() - 2)) : std::string_view();
    if (inner.empty() || inner.find_first_of("[]") != std::string_view::npos)
      fail("'" + std::string(text) + "' is not a section header; write [name]");
    return std::string(inner);
  }

  void define(std::string_view text)
  {
    constexpr std::string_view kDefine = "@define";
    if (!text.starts_with(kDefine) || text.size() == kDefine.size() ||
        !isBlank(text[kDefine.size()]))
      fail("'" + std::string(text) + "' is not a directive; only '@define NAME value' is known");
    const std::string_view rest = trim(text.substr(kDefine.size()));
    std::size_t end = 0;
    while (end < rest.size() && !isBlank(rest[end])) ++end;
    const std::string name(rest.substr(0, end));
    if (end == rest.size()) fail("@define " + name + " has no value");
    if (defines_.contains(name)) fail("@define " + name + " was given before");
    defines_[name] = expand(trim(rest.substr(end)));
  }

  IniEntry entry(std::string_view text) const
  {
    const std::size_t equal = text.find('=');
    if (equal == std::string_view::npos)
      fail("'" + std::string(text) + "' is not 'key = value', '[section]' or a comment");
    const std::string key(trim(text.substr(0, equal)));
    if (key.empty()) fail("'" + std::string(text) + "' has no key before '='");
    for (const char c : key)
      if (isBlank(c)) fail("key '" + key + "' contains a blank");
    if (section_.empty()) fail("key '" + key + "' stands before the first [section]");
    return {section_, key, expand(trim(text.substr(equal + 1))), place()};
  }

  std::string expand(std::string_view text) const
  {
    for (const std::string_view forbidden : {"$env{", "$eval{"})
      if (text.find(forbidden) != std::string_view::npos)
        fail(std::string(forbidden) + "} in '" + std::string(text) +
             "' is refused: a configuration must mean the same everywhere");
    std::string out;
    for (std::size_t i = 0; i < text.size();)
    {
      if (text.substr(i, 2) != "${")
      {
        out += text[i++];
        continue;
      }
      const std::size_t close = text.find('}', i);
      if (close == std::string_view::npos) fail("'" + std::string(text) + "' has ${ without }");
      out += value(std::string(trim(text.substr(i + 2, close - i - 2))));
      i = close + 1;
    }
    return out;
  }

  const std::string& value(const std::string& name) const
  {
    if (const auto found = defines_.find(name); found != defines_.end()) return found->second;
    std::vector<std::string> known;
    for (const auto& [define, text] : defines_) known.push_back(define);
    fail("${" + name + "} was not given by @define" + didYouMean(name, known));
  }

  std::string name_, section_;
  int line_ = 0;
  std::map<std::string, std::string> defines_;
};
}  // namespace

std::string_view trim(std::string_view text)
{
  while (!text.empty() && isBlank(text.front())) text.remove_prefix(1);
  while (!text.empty() && isBlank(text.back())) text.remove_suffix(1);
  return text;
}

std::string_view withoutComment(std::string_view text)
{
  for (std::size_t i = 0; i < text.size(); ++i)
  {
    const bool marker = text[i] == '#' || text[i] == ';' || text.substr(i, 2) == "//";
    if (marker && (i == 0 || isBlank(text[i - 1]))) return text.substr(0, i);
  }
  return text;
}

void parseIni(std::string_view text, std::string_view name,
              const std::function<void(const std::string&)>& on_section,
              const std::function<void(IniEntry)>& on_entry)
{
  Parser parser(name);
  if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);  // byte order mark of some editors
  std::string joined;
  int number = 0;
  while (!text.empty())
  {
    const std::size_t end = text.find('\n');
    std::string_view line = text.substr(0, end);
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
    ++number;
    // An error in a continued line is reported where the line starts.
    if (joined.empty()) parser.setLine(number);
    if (line.find('\0') != std::string_view::npos) parser.fail("binary data; not a text file");
    line = trim(withoutComment(line));
    const bool continued = line.ends_with('\\');
    if (continued) line.remove_suffix(1);
    joined += line;
    if (continued && !text.empty()) continue;
    parser.line(joined, on_section, on_entry);
    joined.clear();
  }
}

}  // namespace slalom::mrpt_io::detail
