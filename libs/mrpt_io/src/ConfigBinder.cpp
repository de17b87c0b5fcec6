// SPDX-License-Identifier: BSD-3-Clause
#include "slalom/mrpt_io/ConfigBinder.h"

#include <algorithm>

#include "FieldText.h"
#include "slalom/mrpt_io/Spelling.h"

namespace slalom::mrpt_io
{
namespace
{

struct BoundField
{
  std::string key, value, origin;
};

struct BoundSection
{
  std::string name;
  std::vector<BoundField> fields;
};

std::string joined(const std::vector<std::string_view>& names)
{
  std::string text;
  for (const std::string_view name : names) text += (text.empty() ? "" : ", ") + std::string(name);
  return text;
}
}  // namespace

struct ConfigBinder::Impl : detail::FieldHandler
{
  explicit Impl(const IniDocument& d) : document(d) {}

  void number(const detail::FieldInfo& field, double& value) override
  {
    read(field, value, detail::toNumber, "a finite number");
    inRange(field, value, detail::toText(value));
    remember(field, detail::toText(value));
  }
  void integer(const detail::FieldInfo& field, int& value) override
  {
    read(field, value, detail::toInteger, "a whole number");
    inRange(field, value, std::to_string(value));
    remember(field, std::to_string(value));
  }
  void flag(const detail::FieldInfo& field, bool& value) override
  {
    read(field, value, detail::toFlag, "true or false (or yes, no, 1, 0)");
    remember(field, value ? "true" : "false");
  }
  void text(const detail::FieldInfo& field, std::string& value) override
  {
    if (const auto* given = find(field)) value = given->text;
    remember(field, value);
  }
  void vector(const detail::FieldInfo& field, Eigen::Vector3d& value) override
  {
    read(field, value, detail::toVector, "three finite numbers x,y,z");
    remember(field, detail::toText(value));
  }
  void choice(const detail::FieldInfo& field, const std::vector<std::string_view>& names,
              std::size_t& index) override
  {
    if (const auto* given = find(field))
    {
      const auto found =
          std::find_if(names.begin(), names.end(),
                       [&](std::string_view name) { return sameIgnoringCase(name, given->text); });
      if (found == names.end())
        fail(field, given->text,
             "must be one of: " + joined(names) +
                 didYouMean(given->text, {names.begin(), names.end()}));
      index = static_cast<std::size_t>(found - names.begin());
    }
    remember(field, std::string(index < names.size() ? names[index] : ""));
  }

  template <class T, class Parse>
  void read(const detail::FieldInfo& field, T& value, Parse parse, std::string_view expected)
  {
    const auto* given = find(field);
    if (!given) return;
    const auto parsed = parse(given->text);
    if (!parsed)
    {
      const bool ranged = detail::toText(field.range) != "any";
      fail(field, given->text,
           "must be " + std::string(expected) +
               (ranged ? " within " + detail::toText(field.range) : ""));
    }
    value = *parsed;
  }

  void inRange(const detail::FieldInfo& field, double value, const std::string& text) const
  {
    if (!(value >= field.range.min && value <= field.range.max))
      fail(field, text, "must be within " + detail::toText(field.range));
  }

  const IniDocument::Value* find(const detail::FieldInfo& field) const
  {
    return document.find(current->name, field.key);
  }

  std::string origin(const detail::FieldInfo& field) const
  {
    const auto* given = find(field);
    return given ? given->origin : "default";
  }

  void remember(const detail::FieldInfo& field, std::string value)
  {
    current->fields.push_back({std::string(field.key), std::move(value), origin(field)});
  }

  [[noreturn]] void fail(const detail::FieldInfo& field, const std::string& value,
                         const std::string& what) const
  {
    throw ConfigError(origin(field) + ": [" + current->name + "] " + std::string(field.key) +
                      " = " + value + ": " + what);
  }

  const BoundSection* bound(std::string_view name) const
  {
    for (const auto& section : sections)
      if (sameIgnoringCase(section->name, name)) return section.get();
    return nullptr;
  }

  std::string unknownSection(const std::string& name) const
  {
    std::vector<std::string> known;
    for (const auto& section : sections) known.push_back(section->name);
    const std::vector<std::string> keys = document.keys(name);
    const std::string place =
        keys.empty() ? "configuration" : document.find(name, keys.front())->origin;
    return place + ": unknown section [" + name + "]" + didYouMean(name, known);
  }

  /// Empty when the key is known.
  std::string unknownKey(const BoundSection& section, const std::string& key) const
  {
    std::vector<std::string> known;
    for (const BoundField& field : section.fields)
    {
      if (sameIgnoringCase(field.key, key)) return "";
      known.push_back(field.key);
    }
    std::string hint = didYouMean(key, known);
    for (const auto& other : sections)
      for (const BoundField& field : other->fields)
        if (hint.empty() && sameIgnoringCase(field.key, key))
          hint = "; it belongs to [" + other->name + "]";
    const IniDocument::Value& value = *document.find(section.name, key);
    return value.origin + ": [" + section.name + "] " + key + " = " + value.text + ": unknown key" +
           hint;
  }

  IniDocument document;
  std::vector<std::unique_ptr<BoundSection>> sections;
  std::vector<std::string> ignored;
  BoundSection* current = nullptr;
};

ConfigBinder::ConfigBinder(const IniDocument& document) : impl_(std::make_unique<Impl>(document)) {}
ConfigBinder::~ConfigBinder() = default;

detail::FieldHandler& ConfigBinder::open(std::string_view section)
{
  impl_->current = nullptr;
  for (const auto& known : impl_->sections)
    if (sameIgnoringCase(known->name, section)) impl_->current = known.get();
  if (!impl_->current)
  {
    impl_->sections.push_back(std::make_unique<BoundSection>());
    impl_->current = impl_->sections.back().get();
    impl_->current->name = section;
  }
  return *impl_;
}

void ConfigBinder::ignore(std::string_view section)
{
  impl_->ignored.emplace_back(section);
}

void ConfigBinder::finish() const
{
  std::string complaints;
  const auto complain = [&](const std::string& line)
  { complaints += (complaints.empty() || line.empty() ? "" : "\n") + line; };
  for (const std::string& name : impl_->document.sections())
  {
    if (std::any_of(impl_->ignored.begin(), impl_->ignored.end(),
                    [&](const std::string& other) { return sameIgnoringCase(other, name); }))
      continue;
    const BoundSection* section = impl_->bound(name);
    if (!section)
      complain(impl_->unknownSection(name));
    else
      for (const std::string& key : impl_->document.keys(name))
        complain(impl_->unknownKey(*section, key));
  }
  if (!complaints.empty()) throw ConfigError(complaints);
}

std::string ConfigBinder::effective() const
{
  std::string text;
  for (const auto& section : impl_->sections)
  {
    text += (text.empty() ? "[" : "\n[") + section->name + "]\n";
    for (const BoundField& field : section->fields)
      text += field.key + " = " + field.value + "  // " + field.origin + "\n";
  }
  return text;
}

}  // namespace slalom::mrpt_io
