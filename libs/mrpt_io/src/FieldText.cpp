// SPDX-License-Identifier: BSD-3-Clause
#include "FieldText.h"

#include <array>
#include <charconv>
#include <cmath>

#include "IniParser.h"
#include "slalom/mrpt_io/Spelling.h"

namespace slalom::mrpt_io::detail
{
namespace
{
template <class Number>
std::optional<Number> fromChars(std::string_view text)
{
  text = trim(text);
  if (text.starts_with('+') && !text.starts_with("+-")) text.remove_prefix(1);
  Number value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (text.empty() || error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}
}  // namespace

std::string toText(double value)
{
  std::array<char, 32> buffer{};
  const auto end = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value).ptr;
  return {buffer.data(), end};
}

std::string toText(const Eigen::Vector3d& value)
{
  return toText(value.x()) + "," + toText(value.y()) + "," + toText(value.z());
}

std::string toText(const core::Range& range)
{
  if (std::isinf(range.min) && std::isinf(range.max)) return "any";
  if (std::isinf(range.max)) return ">= " + toText(range.min);
  if (std::isinf(range.min)) return "<= " + toText(range.max);
  return "[" + toText(range.min) + ", " + toText(range.max) + "]";
}

std::optional<double> toNumber(std::string_view text)
{
  const auto value = fromChars<double>(text);
  return value && std::isfinite(*value) ? value : std::nullopt;
}

std::optional<int> toInteger(std::string_view text)
{
  return fromChars<int>(text);
}

std::optional<bool> toFlag(std::string_view text)
{
  text = trim(text);
  const auto is = [&](std::string_view word) { return sameIgnoringCase(text, word); };
  if (is("true") || is("yes") || is("1")) return true;
  if (is("false") || is("no") || is("0")) return false;
  return std::nullopt;
}

std::optional<Eigen::Vector3d> toVector(std::string_view text)
{
  Eigen::Vector3d value;
  for (int axis = 0; axis < 3; ++axis)
  {
    const std::size_t comma = text.find(',');
    if ((comma == std::string_view::npos) != (axis == 2)) return std::nullopt;
    const auto number = toNumber(text.substr(0, comma));
    if (!number) return std::nullopt;
    value[axis] = *number;
    text.remove_prefix(axis == 2 ? text.size() : comma + 1);
  }
  return value;
}

}  // namespace slalom::mrpt_io::detail
