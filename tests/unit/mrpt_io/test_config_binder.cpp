// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>

#include "ErrorText.h"
#include "slalom/core/Rng.h"
#include "slalom/mrpt_io/ConfigBinder.h"

using namespace slalom;
using mrpt_io::ConfigBinder;
using mrpt_io::ConfigError;
using mrpt_io::IniDocument;
using test::errorText;

namespace
{
enum class Mode
{
  Fast,
  Safe
};

struct Config
{
  double clearance_m = 0.8;
  double open = 1.0;
  int tries = 3;
  bool keep = true;
  std::string label = "x";
  Eigen::Vector3d origin{1, 2, 3};
  Mode mode = Mode::Safe;

  template <class Self, class Visit>
  static void fields(Self& c, Visit&& v)
  {
    using core::Level;
    using core::Range;
    v("clearance_m", c.clearance_m, Range{0.05, 5.0}, "distance to keep");
    v("open", c.open, Range{}, "any number", Level::Expert);
    v("tries", c.tries, Range{1, 1e4}, "attempts");
    v("keep", c.keep, "keep it", Level::Expert);
    v("label", c.label, "a text");
    v("origin", c.origin, "a point");
    v("mode", c.mode, core::Names<Mode>{{"fast", Mode::Fast}, {"safe", Mode::Safe}}, "how");
  }
};

Config bound(const std::string& body)
{
  const auto d = IniDocument::parse("[demo]\n" + body, "a.ini");
  ConfigBinder binder(d);
  Config config;
  binder.bind("demo", config);
  binder.finish();
  return config;
}

std::string bindError(const std::string& body)
{
  return errorText<ConfigError>([&] { (void)bound(body); });
}

TEST(ConfigBinder, AbsentKeysKeepTheDefaultsOfTheStruct)
{
  const Config c = bound("");
  EXPECT_EQ(c.clearance_m, 0.8);
  EXPECT_EQ(c.tries, 3);
  EXPECT_EQ(c.mode, Mode::Safe);
  EXPECT_EQ(c.origin, Eigen::Vector3d(1, 2, 3));
}

TEST(ConfigBinder, ReadsEveryType)
{
  const Config c = bound(
      "clearance_m = +1.25e-1\nTRIES = 7\nkeep = No\nlabel = two words\norigin = -1, 2.5 ,3e1\n"
      "mode = FAST\n");
  EXPECT_EQ(c.clearance_m, 0.125);
  EXPECT_EQ(c.tries, 7);
  EXPECT_FALSE(c.keep);
  EXPECT_EQ(c.label, "two words");
  EXPECT_EQ(c.origin, Eigen::Vector3d(-1, 2.5, 30));
  EXPECT_EQ(c.mode, Mode::Fast);
}

TEST(ConfigBinder, EveryRefusalNamesPlaceValueAndBound)
{
  const std::pair<const char*, const char*> cases[] = {
      {"clearance_m = 1.5x",
       "a.ini:2: [demo] clearance_m = 1.5x: must be a finite number within [0.05, 5]"},
      {"clearance_m = 2*3", "must be a finite number"},
      {"clearance_m =", "must be a finite number"},
      {"clearance_m = nan", "must be a finite number"},
      {"open = inf", "must be a finite number"},
      {"open = 1e999", "must be a finite number"},
      {"open = 0x10", "must be a finite number"},
      {"open = 1,5", "must be a finite number"},
      {"clearance_m = 7", "a.ini:2: [demo] clearance_m = 7: must be within [0.05, 5]"},
      {"clearance_m = -1", "must be within [0.05, 5]"},
      {"tries = 1.5", "must be a whole number within [1, 10000]"},
      {"tries = 1e3", "must be a whole number"},
      {"tries = 99999999999", "must be a whole number"},
      {"tries = 0", "must be within [1, 10000]"},
      {"keep = maybe", "must be true or false"},
      {"keep = 2", "must be true or false"},
      {"origin = 1,2", "must be three finite numbers x,y,z"},
      {"origin = 1,2,3,4", "must be three finite numbers x,y,z"},
      {"origin = 1,2,nan", "must be three finite numbers x,y,z"},
      {"mode = fats", "must be one of: fast, safe; did you mean 'fast'?"},
      {"clearence_m = 1",
       "a.ini:2: [demo] clearence_m = 1: unknown key; did you mean 'clearance_m'?"},
      {"zzz = 1", "a.ini:2: [demo] zzz = 1: unknown key"},
  };
  for (const auto& [body, expected] : cases)
  {
    SCOPED_TRACE(body);
    EXPECT_NE(bindError(body).find(expected), std::string::npos) << bindError(body);
  }
  EXPECT_EQ(bindError("zzz = 1").find("did you mean"), std::string::npos);
}

TEST(ConfigBinder, AFailedBindLeavesTheConfigAlone)
{
  const auto d = IniDocument::parse("[demo]\nclearance_m = 1\ntries = x\n", "a.ini");
  ConfigBinder binder(d);
  Config config;
  EXPECT_THROW(binder.bind("demo", config), ConfigError);
  EXPECT_EQ(config.clearance_m, 0.8);
}

TEST(ConfigBinder, FinishNamesEveryStranger)
{
  auto d =
      IniDocument::parse("[dmeo]\nclearance_m = 1\n[demo]\nlable = a\n[Host]\nx = 1\n", "a.ini");
  d.set("demo.treis=4");
  ConfigBinder binder(d);
  Config config;
  binder.bind("demo", config);
  binder.ignore("host");
  const std::string text = errorText<ConfigError>([&] { binder.finish(); });
  EXPECT_NE(text.find("a.ini:2: unknown section [dmeo]; did you mean 'demo'?"), std::string::npos)
      << text;
  EXPECT_NE(text.find("a.ini:4: [demo] lable = a: unknown key; did you mean 'label'?"),
            std::string::npos)
      << text;
  EXPECT_NE(text.find("--set: [demo] treis = 4: unknown key; did you mean 'tries'?"),
            std::string::npos)
      << text;
  EXPECT_EQ(text.find("Host"), std::string::npos) << text;
}

struct Other
{
  double speed_mps = 1.0;
  template <class Self, class Visit>
  static void fields(Self& c, Visit&& v)
  {
    v("speed_mps", c.speed_mps, core::Range{0.0, 2.0}, "speed");
  }
};

TEST(ConfigBinder, SaysToWhichSectionAMisplacedKeyBelongs)
{
  const auto d = IniDocument::parse("[demo]\nspeed_mps = 1\n", "a.ini");
  ConfigBinder binder(d);
  Config config;
  Other other;
  binder.bind("demo", config);
  binder.bind("other", other);
  EXPECT_NE(errorText<ConfigError>([&] { binder.finish(); }).find("it belongs to [other]"),
            std::string::npos);
}

TEST(ConfigBinder, StructsMayShareASection)
{
  const auto d = IniDocument::parse("[demo]\nspeed_mps = 2\ntries = 4\n", "a.ini");
  ConfigBinder binder(d);
  Config config;
  Other other;
  binder.bind("demo", config);
  binder.bind("demo", other);
  binder.finish();
  EXPECT_EQ(other.speed_mps, 2.0);
  EXPECT_EQ(config.tries, 4);
}

TEST(ConfigBinder, ADefaultOutsideItsOwnRangeIsCaught)
{
  ConfigBinder binder{IniDocument()};
  Other other;
  other.speed_mps = 3.0;
  EXPECT_NE(errorText<ConfigError>([&] { binder.bind("other", other); }).find("default: [other]"),
            std::string::npos);
}

// Law: effective() read back gives the same config, bit by bit, and no complaint.
TEST(ConfigBinder, EffectiveConfigurationReadsBack)
{
  for (std::uint64_t seed = 1; seed <= 300; ++seed)
  {
    SCOPED_TRACE(seed);
    core::Rng rng(seed);
    Config first;
    first.clearance_m = rng.uniform(0.05, 5.0);
    first.open = rng.normal() * std::pow(10.0, rng.integer(-200, 200));
    first.tries = rng.integer(1, 10000);
    first.keep = rng.uniform() < 0.5;
    first.label = rng.uniform() < 0.3 ? "" : "a/b c#d";
    first.origin = rng.normal3(1e3);
    first.mode = rng.uniform() < 0.5 ? Mode::Fast : Mode::Safe;
    ConfigBinder writer{IniDocument()};
    writer.bind("demo", first);

    const auto again = IniDocument::parse(writer.effective(), "effective.ini");
    ConfigBinder reader(again);
    Config second;
    reader.bind("demo", second);
    EXPECT_NO_THROW(reader.finish());
    EXPECT_EQ(second.clearance_m, first.clearance_m);
    EXPECT_EQ(second.open, first.open);
    EXPECT_EQ(second.tries, first.tries);
    EXPECT_EQ(second.keep, first.keep);
    EXPECT_EQ(second.label, first.label);
    EXPECT_EQ(second.origin, first.origin);
    EXPECT_EQ(second.mode, first.mode);
  }
}

TEST(ConfigBinder, EffectiveNamesOrigins)
{
  auto d = IniDocument::parse("[demo]\ntries = 4\n", "a.ini");
  d.set("demo.keep=0");
  ConfigBinder binder(d);
  Config config;
  binder.bind("demo", config);
  const std::string text = binder.effective();
  EXPECT_NE(text.find("[demo]\nclearance_m = 0.8  // default\n"), std::string::npos) << text;
  EXPECT_NE(text.find("tries = 4  // a.ini:2\n"), std::string::npos) << text;
  EXPECT_NE(text.find("keep = false  // --set\n"), std::string::npos) << text;
}

TEST(ConfigBinder, DescribeSplitsPublicAndExpert)
{
  const std::string text = mrpt_io::describe("demo", Config());
  const std::size_t expert = text.find("Expert keys");
  ASSERT_NE(expert, std::string::npos);
  EXPECT_LT(text.find("| `clearance_m` | 0.8 | [0.05, 5] | distance to keep |"), expert);
  EXPECT_LT(text.find("| `mode` | safe | fast, safe | how |"), expert);
  EXPECT_GT(text.find("| `keep` | true | true, false | keep it |"), expert);
  EXPECT_EQ(mrpt_io::describe("other", Other()).find("Expert"), std::string::npos);
}
}  // namespace
