// SPDX-License-Identifier: BSD-3-Clause
#include "RowFiles.h"

#include <array>
#include <charconv>
#include <cmath>

namespace slalom::report::detail
{
std::string fixedNumber(double value, int decimals)
{
  if (!std::isfinite(value)) return "";
  std::array<char, 400> text{};  // the longest double has 309 digits before the point
  const auto end = std::to_chars(text.data(), text.data() + text.size(), value,
                                 std::chars_format::fixed, decimals);
  const std::string_view number(text.data(), static_cast<std::size_t>(end.ptr - text.data()));
  const bool is_zero = number.find_first_of("123456789") == std::string_view::npos;
  return std::string(is_zero && number.starts_with('-') ? number.substr(1) : number);
}

std::string csvField(std::string_view text)
{
  if (text.find_first_of(",\"\r\n") == std::string_view::npos) return std::string(text);
  std::string quoted = "\"";
  for (const char c : text)
  {
    if (c == '"') quoted += '"';
    quoted += c;
  }
  return quoted + "\"";
}

CsvRow& CsvRow::append(std::string_view field)
{
  if (!first_) line_ += ',';
  first_ = false;
  line_ += field;
  return *this;
}

CsvRow& CsvRow::number(double value, int decimals)
{
  return append(fixedNumber(value, decimals));
}
CsvRow& CsvRow::integer(std::uint64_t value)
{
  return append(std::to_string(value));
}
CsvRow& CsvRow::text(std::string_view value)
{
  return append(csvField(value));
}

namespace
{
/// From the integer, so that the text rises exactly when the stamp does.
std::string microsecondsAsSeconds(std::int64_t us)
{
  constexpr std::int64_t kMillion = 1000000;
  const std::int64_t size = us < 0 ? -us : us;
  const std::string fraction = std::to_string(size % kMillion);
  return (us < 0 ? "-" : "") + std::to_string(size / kMillion) + "." +
         std::string(6 - fraction.size(), '0') + fraction;
}
}  // namespace

void TumWriter::write(const core::TimedPose& pose)
{
  const double stamp = epoch_s_ + pose.t;
  if (!std::isfinite(stamp) || !pose.position.allFinite() || !pose.orientation.coeffs().allFinite())
    return;
  const std::int64_t stamp_us = std::llround(stamp * 1e6);
  if (stamp_us <= last_stamp_us_) return;
  last_stamp_us_ = stamp_us;

  std::string row = microsecondsAsSeconds(stamp_us);
  for (const double value : {pose.position.x(), pose.position.y(), pose.position.z()})
    row += " " + fixedNumber(value, 6);
  for (const double value :
       {pose.orientation.x(), pose.orientation.y(), pose.orientation.z(), pose.orientation.w()})
    row += " " + fixedNumber(value, 9);
  file.write(row + "\n");
}

}  // namespace slalom::report::detail
