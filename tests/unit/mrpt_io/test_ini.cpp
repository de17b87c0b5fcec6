// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <mrpt/config/CConfigFileMemory.h>

#include <filesystem>
#include <fstream>

#include "ErrorText.h"
#include "slalom/core/Rng.h"
#include "slalom/mrpt_io/IniDocument.h"

using slalom::mrpt_io::ConfigError;
using slalom::mrpt_io::IniDocument;
using slalom::test::errorText;

namespace
{
std::string parseError(std::string_view text)
{
  return errorText<ConfigError>([&] { (void)IniDocument::parse(text, "a.ini"); });
}

TEST(IniDocument, KnowsTheOriginOfEveryValue)
{
  const auto d = IniDocument::parse(
      "// head\n# x\n; y\n[Map]  // tail\nres = 0.2   // metres\n\nname=a b;c//d  # tail\r\nempty "
      "=\n",
      "a.ini");
  EXPECT_EQ(d.find("map", "RES")->text, "0.2");
  EXPECT_EQ(d.find("Map", "res")->origin, "a.ini:5");
  EXPECT_EQ(d.find("map", "name")->text, "a b;c//d");
  EXPECT_EQ(d.find("map", "empty")->text, "");
  EXPECT_EQ(d.find("map", "absent"), nullptr);
  EXPECT_EQ(d.find("absent", "res"), nullptr);
  EXPECT_EQ(d.sections(), std::vector<std::string>{"Map"});
}

TEST(IniDocument, ExpandsDefinitions)
{
  const auto d =
      IniDocument::parse("@define R 0.5\n@define TWO ${R},${R}\n[a]\nv = ${TWO},${R}\n", "a.ini");
  EXPECT_EQ(d.find("a", "v")->text, "0.5,0.5,0.5");
}

TEST(IniDocument, ContinuesLinesButNeverThroughComments)
{
  const auto d = IniDocument::parse("[a]\nv = 1, \\\n  2\n// comment \\\nw = 3\n", "a.ini");
  EXPECT_EQ(d.find("a", "v")->text, "1, 2");
  EXPECT_EQ(d.find("a", "w")->text, "3");
}

TEST(IniDocument, EveryMistakeNamesItsLine)
{
  const std::pair<const char*, const char*> cases[] = {
      {"[a]\nk = 1\nK = 2\n", "a.ini:3: [a] K was already set at a.ini:2"},
      {"[a]\nk = 1\n[A]\nk = 2\n", "a.ini:4: [A] k was already set at a.ini:2"},
      {"k = 1\n", "a.ini:1: key 'k' stands before the first [section]"},
      {"[a]\njust words\n", "a.ini:2: 'just words' is not 'key = value'"},
      {"[a\n", "a.ini:1: '[a' is not a section header"},
      {"[]\n", "is not a section header"},
      {"[a]\n = 3\n", "has no key before '='"},
      {"[a]\ntwo words = 3\n", "key 'two words' contains a blank"},
      {"@define RADIUS 1\n[a]\nk = ${RADUIS}\n",
       "a.ini:3: ${RADUIS} was not given by @define; did you mean 'RADIUS'?"},
      {"[a]\nk = ${R\n", "${ without }"},
      {"[a]\nk = $env{HOME}\n", "a.ini:2: $env{}"},
      {"[a]\nk = $eval{1+1}\n", "a.ini:2: $eval{}"},
      {"@include x.ini\n", "is not a directive"},
      {"@define A 1\n@define A 2\n", "a.ini:2: @define A was given before"},
      {"@define A\n", "@define A has no value"},
  };
  for (const auto& [text, expected] : cases)
  {
    SCOPED_TRACE(text);
    EXPECT_NE(parseError(text).find(expected), std::string::npos) << parseError(text);
  }
  EXPECT_NE(parseError(std::string_view("[a]\nk = \0\n", 9)).find("binary"), std::string::npos);
}

TEST(IniDocument, UnreadableFilesAreErrors)
{
  const auto read = [](const std::filesystem::path& file)
  { return errorText<ConfigError>([&] { (void)IniDocument::read(file); }); };
  EXPECT_NE(read("no/such.ini").find("no such configuration file"), std::string::npos);
  EXPECT_NE(read(std::filesystem::temp_directory_path()).find("not a file"), std::string::npos);

  const auto empty = std::filesystem::path(::testing::TempDir()) / "slalom_empty.ini";
  std::ofstream(empty).close();
  EXPECT_TRUE(IniDocument::read(empty).sections().empty());
  std::filesystem::remove(empty);
}

TEST(IniDocument, LaterDocumentsAndAssignmentsWinKeyByKey)
{
  auto d = IniDocument::parse("[a]\nx = 1\ny = 2\nz = 3\n", "low.ini");
  d.overlay(IniDocument::parse("[A]\nY = 20\n[b]\nq = 1\n", "high.ini"));
  d.set("a.z = 30");
  d.set("c.path.with.dots=a=b");
  EXPECT_EQ(d.find("a", "x")->origin, "low.ini:2");
  EXPECT_EQ(d.find("a", "y")->text, "20");
  EXPECT_EQ(d.find("a", "y")->origin, "high.ini:2");
  EXPECT_EQ(d.find("a", "z")->text, "30");
  EXPECT_EQ(d.find("a", "z")->origin, "--set");
  EXPECT_EQ(d.find("c", "path.with.dots")->text, "a=b");
  for (const char* bad : {"a.x", "x=1", ".x=1", "a.=1", "", "=", "a.x=1 // c", "a.x=1\n2"})
  {
    SCOPED_TRACE(bad);
    EXPECT_THROW(d.set(bad), ConfigError);
  }
}

TEST(IniDocument, PassesThroughMrptUnchanged)
{
  const auto d = IniDocument::parse("[a]\nx = 1.5\ns = hello world\n[b]\nv = 1,2,3\n", "a.ini");
  mrpt::config::CConfigFileMemory host;
  d.copyTo(host);
  const auto back = IniDocument::from(host, "host");
  ASSERT_EQ(back.sections().size(), 2U);
  for (const std::string& section : d.sections())
    for (const std::string& key : d.keys(section))
      EXPECT_EQ(back.find(section, key)->text, d.find(section, key)->text) << section << "." << key;
  EXPECT_EQ(back.find("a", "x")->origin, "host");
}

TEST(IniDocument, NoiseNeverCrashesAndErrorsAreConfigErrors)
{
  constexpr std::string_view kAlphabet = "[]=@define ${}#;/\\\nab1.,\t\"";
  for (std::uint64_t seed = 1; seed <= 2000; ++seed)
  {
    SCOPED_TRACE(seed);
    slalom::core::Rng rng(seed);
    std::string text = rng.uniform() < 0.5 ? "[a]\n" : "";
    for (int i = rng.integer(0, 60); i > 0; --i)
      text += kAlphabet[static_cast<std::size_t>(
          rng.integer(0, static_cast<int>(kAlphabet.size()) - 1))];
    try
    {
      (void)IniDocument::parse(text, "noise");
    }
    catch (const ConfigError& e)
    {
      EXPECT_EQ(std::string(e.what()).rfind("noise:", 0), 0U) << e.what();
    }
  }
}
}  // namespace
