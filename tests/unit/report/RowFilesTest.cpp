// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <clocale>
#include <cmath>
#include <limits>
#include <sstream>

#include "RowFiles.h"
#include "TempFolder.h"
#include "slalom/core/Rng.h"

namespace slalom::report::detail
{
namespace
{
TEST(FixedNumber, IsPlainDecimal)
{
  EXPECT_EQ(fixedNumber(1.0, 3), "1.000");
  EXPECT_EQ(fixedNumber(-0.0004, 3), "0.000");
  EXPECT_EQ(fixedNumber(-0.0006, 3), "-0.001");
  EXPECT_EQ(fixedNumber(1e20, 0), "100000000000000000000");
  EXPECT_EQ(fixedNumber(std::nan(""), 3), "");
  EXPECT_EQ(fixedNumber(-std::numeric_limits<double>::infinity(), 3), "");
  EXPECT_FALSE(fixedNumber(-std::numeric_limits<double>::max(), 9).empty());
}

TEST(FixedNumber, ReadsBackWithinHalfAUnitOfItsLastDigit)
{
  for (std::uint64_t seed = 0; seed < 20; ++seed)
  {
    SCOPED_TRACE(seed);
    core::Rng rng(seed);
    for (int i = 0; i < 200; ++i)
    {
      const double value = rng.uniform(-1.0, 1.0) * std::pow(10.0, rng.integer(-8, 5));
      EXPECT_NEAR(std::stod(fixedNumber(value, 6)), value, 0.5000001e-6);
    }
  }
}

/// Splits one CSV line by RFC 4180.
std::vector<std::string> parseCsv(const std::string& line)
{
  std::vector<std::string> fields(1);
  bool quoted = false;
  for (std::size_t i = 0; i < line.size(); ++i)
  {
    if (line[i] == '"' && quoted && i + 1 < line.size() && line[i + 1] == '"')
      fields.back() += line[++i];
    else if (line[i] == '"')
      quoted = !quoted;
    else if (line[i] == ',' && !quoted)
      fields.emplace_back();
    else
      fields.back() += line[i];
  }
  return fields;
}

TEST(CsvRow, AnyTextReadsBack)
{
  EXPECT_EQ(csvField("plain"), "plain");
  EXPECT_EQ(csvField("a,b"), "\"a,b\"");
  EXPECT_EQ(csvField("say \"no\""), "\"say \"\"no\"\"\"");
  for (std::uint64_t seed = 0; seed < 50; ++seed)
  {
    SCOPED_TRACE(seed);
    core::Rng rng(seed);
    std::vector<std::string> fields(static_cast<std::size_t>(rng.integer(1, 6)));
    CsvRow row;
    for (std::string& field : fields)
    {
      for (int n = rng.integer(0, 8); n > 0; --n) field += "ab, \"\n"[rng.integer(0, 5)];
      row.text(field);
    }
    const std::string line = row.line();
    EXPECT_EQ(parseCsv(line.substr(0, line.size() - 1)), fields);
  }
}

TEST(TumWriter, EightColumnsSingleSpacesRisingStamps)
{
  for (std::uint64_t seed = 0; seed < 10; ++seed)
  {
    SCOPED_TRACE(seed);
    const test::TempFolder folder;
    core::Rng rng(seed);
    TumWriter writer(folder / "a.tum", 1.7e9);
    double t = 0.0;
    for (int i = 0; i < 300; ++i)
    {
      // Repeated, nearly repeated and falling stamps included.
      t += rng.integer(0, 3) == 0 ? rng.uniform(-1e-2, 2e-6) : rng.uniform(0.0, 0.1);
      core::TimedPose pose{t, rng.uniform3(-100.0, 100.0), core::fromYaw(rng.uniform(-3.0, 3.0))};
      if (i % 50 == 7) pose.position.y() = std::nan("");
      writer.write(pose);
    }
    writer.file.commit();
    const auto lines = test::linesOf(folder / "a.tum");
    ASSERT_GT(lines.size(), 150u);
    std::string last;
    for (const std::string& line : lines)
    {
      EXPECT_EQ(line.find("  "), std::string::npos);
      EXPECT_FALSE(line.starts_with(' ') || line.ends_with(' '));
      std::istringstream words(line);
      std::vector<std::string> columns;
      for (std::string word; words >> word;) columns.push_back(word);
      ASSERT_EQ(columns.size(), 8u);
      ASSERT_EQ(columns[0].size(), 17u);  // 10 digits, point, 6 digits: text order is time order
      EXPECT_LT(last, columns[0]);
      last = columns[0];
      double norm2 = 0.0;
      for (std::size_t c = 4; c < 8; ++c) norm2 += std::pow(std::stod(columns[c]), 2);
      EXPECT_NEAR(norm2, 1.0, 1e-8);
    }
  }
}

TEST(TumWriter, WritesWhatItIsGiven)
{
  const test::TempFolder folder;
  TumWriter writer(folder / "a.tum", 1700000000.0);
  writer.write({0.1, {1.0, -2.5, 0.0}, Eigen::Quaterniond(1.0, 0.0, 0.0, 0.0)});
  writer.file.commit();
  EXPECT_EQ(test::contentOf(folder / "a.tum"),
            "1700000000.100000 1.000000 -2.500000 0.000000 0.000000000 0.000000000 0.000000000 "
            "1.000000000\n");
}
}  // namespace
}  // namespace slalom::report::detail
