// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <string_view>

#include "slalom/core/Fields.h"
#include "slalom/mrpt_io/IniDocument.h"

namespace slalom::mrpt_io
{
/** Fills config structs from an IniDocument through their fields() lists, and complains about
 * everything else.
 *
 *    ConfigBinder binder(document);
 *    binder.bind("mapping", config.mapper);      // throws on malformed, out-of-range, NaN
 *    binder.finish();                            // throws on unknown sections and keys ("did you
 * mean ...?") write(binder.effective());                  // every value with its origin
 */
class ConfigBinder
{
 public:
  explicit ConfigBinder(const IniDocument& document);

  template <class Config>
  void bind(std::string_view section, Config& config);

  /// Sections that belong to somebody else (an MRPT host) and are not judged.
  void ignore(std::string_view section);
  /// @throws ConfigError naming every unknown section and key with its nearest known spelling.
  void finish() const;
  /// INI text of every bound value: `key = value  // origin`; bound sections in order of binding.
  [[nodiscard]] std::string effective() const;

 private:
  // filled in by the implementation
};

/// Markdown table of all fields of a config struct: key, default, range, effect. Source of
/// docs/configuration.md.
template <class Config>
[[nodiscard]] std::string describe(std::string_view section, const Config& defaults);

}  // namespace slalom::mrpt_io
