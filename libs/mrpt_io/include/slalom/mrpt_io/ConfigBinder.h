// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <memory>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "slalom/core/Fields.h"
#include "slalom/mrpt_io/IniDocument.h"

namespace slalom::mrpt_io
{
namespace detail
{
/// What a fields() list says about one field.
struct FieldInfo
{
  std::string_view key, help;
  core::Level level = core::Level::Public;
  core::Range range;
};

/// Something that walks the fields of a config struct: reads them, or describes them.
class FieldHandler
{
 public:
  virtual ~FieldHandler() = default;
  virtual void number(const FieldInfo& field, double& value) = 0;
  virtual void integer(const FieldInfo& field, int& value) = 0;
  virtual void flag(const FieldInfo& field, bool& value) = 0;
  virtual void text(const FieldInfo& field, std::string& value) = 0;
  virtual void vector(const FieldInfo& field, Eigen::Vector3d& value) = 0;
  virtual void choice(const FieldInfo& field, const std::vector<std::string_view>& names,
                      std::size_t& index) = 0;
};

/// The visitor that fields() sees.
class FieldVisitor
{
 public:
  explicit FieldVisitor(FieldHandler& handler) : handler_(handler) {}

  using Level = core::Level;
  using Text = std::string_view;
  void operator()(Text key, double& value, core::Range range, Text help, Level l = Level::Public)
  {
    handler_.number({key, help, l, range}, value);
  }
  void operator()(Text key, int& value, core::Range range, Text help, Level l = Level::Public)
  {
    handler_.integer({key, help, l, range}, value);
  }
  void operator()(Text key, bool& value, Text help, Level l = Level::Public)
  {
    handler_.flag({key, help, l, {}}, value);
  }
  void operator()(Text key, std::string& value, Text help, Level l = Level::Public)
  {
    handler_.text({key, help, l, {}}, value);
  }
  void operator()(Text key, Eigen::Vector3d& value, Text help, Level l = Level::Public)
  {
    handler_.vector({key, help, l, {}}, value);
  }
  template <class E>
  requires std::is_enum_v<E>
  void operator()(Text key, E& value, const core::Names<std::type_identity_t<E>>& names, Text help,
                  Level l = Level::Public)
  {
    std::vector<std::string_view> spellings;
    std::size_t index = names.size();
    for (const auto& [spelling, enumerator] : names)
    {
      if (enumerator == value && index == names.size()) index = spellings.size();
      spellings.push_back(spelling);
    }
    handler_.choice({key, help, l, {}}, spellings, index);
    if (index < names.size()) value = names[index].second;
  }

 private:
  FieldHandler& handler_;
};

/// Collects the rows of describe().
class FieldTable : public FieldHandler
{
 public:
  explicit FieldTable(std::string_view section) : section_(section) {}
  void number(const FieldInfo& field, double& value) override;
  void integer(const FieldInfo& field, int& value) override;
  void flag(const FieldInfo& field, bool& value) override;
  void text(const FieldInfo& field, std::string& value) override;
  void vector(const FieldInfo& field, Eigen::Vector3d& value) override;
  void choice(const FieldInfo& field, const std::vector<std::string_view>& names,
              std::size_t& index) override;
  [[nodiscard]] std::string markdown() const;

 private:
  void row(const FieldInfo& field, const std::string& value, const std::string& allowed);
  std::string section_, public_, expert_;
};
}  // namespace detail

/** Fills config structs from an IniDocument through their fields() lists, and complains about
 * everything else.
 *
 *    ConfigBinder binder(document);
 *    binder.bind("mapping", config.mapper);      // throws on malformed, out-of-range, NaN
 *    binder.finish();                            // throws on unknown sections and keys ("did you
 * mean ...?") write(binder.effective());                  // every value with its origin
 *
 *  Every error is a ConfigError of the form `file:line: [section] key = value: what is allowed`.
 *  Several structs may share a section. The document is copied. */
class ConfigBinder
{
 public:
  explicit ConfigBinder(const IniDocument& document);
  ~ConfigBinder();

  /// @throws ConfigError; then `config` is unchanged.
  template <class Config>
  void bind(std::string_view section, Config& config)
  {
    Config read = config;
    detail::FieldVisitor visitor(open(section));
    Config::fields(read, visitor);
    config = std::move(read);
  }

  /// Sections that belong to somebody else (an MRPT host) and are not judged.
  void ignore(std::string_view section);
  /// @throws ConfigError naming every unknown section and key with its nearest known spelling.
  void finish() const;
  /// INI text of every bound value: `key = value  // origin`; bound sections in order of binding.
  [[nodiscard]] std::string effective() const;

 private:
  detail::FieldHandler& open(std::string_view section);

  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Markdown tables of all fields of a config struct: key, default, range, effect; the public keys
/// first, the expert keys apart. Source of docs/configuration.md.
template <class Config>
[[nodiscard]] std::string describe(std::string_view section, const Config& defaults)
{
  Config copy = defaults;
  detail::FieldTable table(section);
  detail::FieldVisitor visitor(table);
  Config::fields(copy, visitor);
  return table.markdown();
}

}  // namespace slalom::mrpt_io
