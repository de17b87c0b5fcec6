// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "slalom/core/VehicleState.h"
#include "slalom/report/AtomicFile.h"

namespace slalom::report::detail
{
/// Number with a fixed count of decimals, independent of the locale; "" when not finite; no "-0".
[[nodiscard]] std::string fixedNumber(double value, int decimals);

/// A CSV field [RFC 4180]: quoted when it holds a comma, a quote or a line break.
[[nodiscard]] std::string csvField(std::string_view text);

/// Collects the fields of one CSV row.
class CsvRow
{
 public:
  CsvRow& number(double value, int decimals = 4);  ///< empty field when not finite
  CsvRow& integer(std::uint64_t value);
  CsvRow& text(std::string_view value);
  [[nodiscard]] std::string line() const { return line_ + "\n"; }

 private:
  CsvRow& append(std::string_view field);
  std::string line_;
  bool first_ = true;
};

/** Rows "stamp x y z qx qy qz qw" with strictly rising stamps: a pose that is not finite or whose
 * stamp, rounded to a microsecond, is not above the last one, is left out. */
class TumWriter
{
 public:
  TumWriter(std::filesystem::path path, double epoch_s) : file(std::move(path)), epoch_s_(epoch_s)
  {
  }
  void write(const core::TimedPose& pose);

  AtomicFile file;

 private:
  double epoch_s_;
  std::int64_t last_stamp_us_ = INT64_MIN;
};

}  // namespace slalom::report::detail
