// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <map>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace mrpt::config
{
class CConfigFileBase;
}

namespace slalom::mrpt_io
{
/// A configuration mistake: says file, line, section, key, value and bound. Programs exit with 2.
class ConfigError : public std::runtime_error
{
 public:
  using std::runtime_error::runtime_error;
};

/** The text of one or several INI files, with the origin of every value. MRPT's dialect
 * (`[Section]`, `key = value`,
 *  `//` `#` `;` comments, `@define NAME value` with `${NAME}`), read strictly: duplicates, keys
 * outside a section, lines that are not key = value, unknown ${NAME}, and $env{} / $eval{} are
 * errors. Sections and keys are case-insensitive on look-up but keep their spelling. */
class IniDocument
{
 public:
  struct Value
  {
    std::string text;
    std::string origin;  ///< "file.ini:12", "--set", "host"
  };

  [[nodiscard]] static IniDocument read(
      const std::filesystem::path& file);  ///< @throws ConfigError
  [[nodiscard]] static IniDocument parse(std::string_view text,
                                         std::string_view name);  ///< @throws ConfigError
  /// What an MRPT host hands to loadConfigFile().
  [[nodiscard]] static IniDocument from(const mrpt::config::CConfigFileBase& source,
                                        std::string_view name);

  /// Later documents win, key by key.
  void overlay(const IniDocument& over);
  /// "section.key=value" from the command line. @throws ConfigError
  void set(std::string_view assignment);

  [[nodiscard]] const Value* find(std::string_view section, std::string_view key) const;
  [[nodiscard]] std::vector<std::string> sections() const;
  [[nodiscard]] std::vector<std::string> keys(std::string_view section) const;

  /// Copies all values, so that MRPT code and plugins can read them.
  void copyTo(mrpt::config::CConfigFileBase& target) const;

 private:
  struct CaseInsensitive
  {
    using is_transparent = void;
    bool operator()(std::string_view a, std::string_view b) const;
  };
  std::map<std::string, std::map<std::string, Value, CaseInsensitive>, CaseInsensitive> values_;
};

}  // namespace slalom::mrpt_io
