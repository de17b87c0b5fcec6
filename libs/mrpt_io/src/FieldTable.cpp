// SPDX-License-Identifier: BSD-3-Clause
#include "FieldText.h"
#include "slalom/mrpt_io/ConfigBinder.h"

namespace slalom::mrpt_io::detail
{
void FieldTable::number(const FieldInfo& field, double& value)
{
  row(field, toText(value), toText(field.range));
}

void FieldTable::integer(const FieldInfo& field, int& value)
{
  row(field, std::to_string(value), toText(field.range) + ", whole");
}

void FieldTable::flag(const FieldInfo& field, bool& value)
{
  row(field, value ? "true" : "false", "true, false");
}

void FieldTable::text(const FieldInfo& field, std::string& value)
{
  row(field, value, "text");
}

void FieldTable::vector(const FieldInfo& field, Eigen::Vector3d& value)
{
  row(field, toText(value), "x,y,z");
}

void FieldTable::choice(const FieldInfo& field, const std::vector<std::string_view>& names,
                        std::size_t& index)
{
  std::string allowed;
  for (const std::string_view name : names)
    allowed += (allowed.empty() ? "" : ", ") + std::string(name);
  row(field, index < names.size() ? std::string(names[index]) : "", allowed);
}

void FieldTable::row(const FieldInfo& field, const std::string& value, const std::string& allowed)
{
  std::string& table = field.level == core::Level::Public ? public_ : expert_;
  table += "| `" + std::string(field.key) + "` | " + (value.empty() ? "(empty)" : value) + " | " +
           allowed + " | " + std::string(field.help) + " |\n";
}

std::string FieldTable::markdown() const
{
  constexpr std::string_view kHead = "| key | default | allowed | effect |\n|---|---|---|---|\n";
  std::string text = "## [" + section_ + "]\n";
  if (!public_.empty()) text += "\n" + std::string(kHead) + public_;
  if (!expert_.empty()) text += "\nExpert keys:\n\n" + std::string(kHead) + expert_;
  return text;
}

}  // namespace slalom::mrpt_io::detail
