// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <mrpt/obs/CActionCollection.h>
#include <mrpt/obs/CObservationComment.h>
#include <mrpt/obs/CObservationIMU.h>
#include <mrpt/obs/CObservationOdometry.h>
#include <mrpt/obs/CSensoryFrame.h>

#include "ErrorText.h"
#include "Rawlogs.h"
#include "slalom/core/Rng.h"

using namespace slalom;
using mrpt_io::RawlogError;
using mrpt_io::RawlogReader;
namespace fs = std::filesystem;

namespace
{
mrpt::obs::CObservationComment comment(int i)
{
  mrpt::obs::CObservationComment c;
  c.timestamp = mrpt::Clock::fromDouble(1.7e9 + i);
  c.text = "number " + std::to_string(i);
  return c;
}

mrpt::obs::CObservationOdometry odometry(double x)
{
  mrpt::obs::CObservationOdometry o;
  o.timestamp = mrpt::Clock::fromDouble(1.7e9 + x);
  o.odometry = mrpt::poses::CPose2D(x, 0, 0);
  return o;
}

struct RawlogReaderTest : ::testing::Test
{
  test::Reading read(const std::string& bytes)
  {
    const fs::path file = folder.path() / "a.rawlog";
    test::writeFile(file, bytes);
    return test::readAll(file);
  }
  test::TempFolder folder;
};

TEST_F(RawlogReaderTest, DeliversTheSameObjectsFromPlainGzipAndJoinedGzip)
{
  std::string plain;
  std::vector<std::string> objects;
  for (int i = 0; i < 50; ++i)
  {
    const auto c = comment(i);
    objects.push_back(test::serialized(&c));
    plain += objects.back();
  }
  const std::size_t half = plain.size() / 2;  // inside an object
  for (const std::string& bytes :
       {plain, test::gzipped(plain),
        test::gzipped(plain.substr(0, half)) + test::gzipped(plain.substr(half))})
  {
    const test::Reading reading = read(bytes);
    EXPECT_EQ(reading.error, "");
    EXPECT_EQ(reading.objects, objects);
    EXPECT_EQ(reading.statistics.objects, 50U);
    EXPECT_EQ(reading.statistics.observations.at("mrpt::obs::CObservationComment"), 50U);
  }
}

TEST_F(RawlogReaderTest, FlattensSensoryFramesAndCountsTheRest)
{
  mrpt::obs::CSensoryFrame frame;
  for (int i = 0; i < 3; ++i)
    frame.insert(std::make_shared<mrpt::obs::CObservationOdometry>(odometry(i)));
  const mrpt::obs::CActionCollection actions;
  const auto last = comment(9);
  const test::Reading reading =
      read(test::gzipped(test::serialized(&actions) + test::serialized(&frame) +
                         test::serialized(nullptr) + test::serialized(&last)));
  EXPECT_EQ(reading.error, "");
  ASSERT_EQ(reading.objects.size(), 4U);
  EXPECT_EQ(reading.objects.back(), test::serialized(&last));
  EXPECT_EQ(reading.statistics.observations.at("mrpt::obs::CObservationOdometry"), 3U);
  EXPECT_EQ(reading.statistics.skipped.at("mrpt::obs::CActionCollection"), 1U);
  EXPECT_EQ(reading.statistics.skipped.at("null object"), 1U);
  EXPECT_EQ(reading.statistics.objects, 4U);
}

/// An object of a class that MRPT 2.5.8 does not know.
std::string foreign(std::string bytes)
{
  const std::string known = "CObservationIMU", unknown = "CObservationXYZ";
  return bytes.replace(bytes.find(known), known.size(), unknown);
}

// Law: an unknown class costs itself and nothing else, wherever it stands and whatever it holds.
TEST_F(RawlogReaderTest, SkipsUnknownClassesWithoutLosingOthers)
{
  for (std::uint64_t seed = 1; seed <= 60; ++seed)
  {
    SCOPED_TRACE(seed);
    core::Rng rng(seed);
    std::string plain;
    std::vector<std::string> known;
    std::uint64_t strangers = 0;
    for (int i = 0; i < 20; ++i)
    {
      mrpt::obs::CObservationIMU imu;
      imu.timestamp = mrpt::Clock::fromDouble(1.7e9 + i);
      for (std::size_t k = 0; k < imu.rawMeasurements.size(); ++k)
        imu.rawMeasurements[k] = rng.normal() * 1e3;
      const std::string bytes = test::serialized(&imu);
      if (rng.uniform() < 0.5)
      {
        plain += foreign(bytes);
        ++strangers;
        continue;
      }
      plain += bytes;
      known.push_back(bytes);
    }
    const auto last = comment(1);
    known.push_back(test::serialized(&last));
    plain += known.back();
    const test::Reading reading = read(rng.uniform() < 0.5 ? plain : test::gzipped(plain));
    EXPECT_EQ(reading.error, "");
    EXPECT_EQ(reading.objects, known);
    std::uint64_t skipped = 0;
    for (const auto& [reason, count] : reading.statistics.skipped) skipped += count;
    // Strangers in a row are skipped as one: their lengths are not known.
    EXPECT_LE(skipped, strangers);
    EXPECT_EQ(skipped > 0, strangers > 0);
  }
}

TEST_F(RawlogReaderTest, RefusesWhatIsNotARawlog)
{
  const auto c = comment(1);
  const std::pair<std::string, const char*> cases[] = {
      {"", "the file is empty"},
      {"x", "not a rawlog"},
      {"This is a text file.\nIt has lines.\n", "not a rawlog"},
      {std::string(1000, '\0'), "not a rawlog"},
      {std::string(1000, '\xff'), "not a rawlog"},
      {"\x28\xb5\x2f\xfd\x24", "zstd"},
      {"PK\x03\x04zip", "archive"},
      {"BZh91AY", "archive"},
      {test::gzipped(""), "not a rawlog"},
      {test::gzipped("just text, compressed"), "not a rawlog"},
      {"\x1f\x8b", "not a rawlog"},
  };
  for (const auto& [bytes, expected] : cases)
  {
    SCOPED_TRACE(expected);
    const test::Reading reading = read(bytes);
    EXPECT_TRUE(reading.refused);
    EXPECT_NE(reading.error.find(expected), std::string::npos) << reading.error;
    EXPECT_NE(reading.error.find("a.rawlog"), std::string::npos) << reading.error;
    EXPECT_EQ(reading.error.find('\n'), std::string::npos) << reading.error;
  }
}

TEST_F(RawlogReaderTest, MissingFilesAndFoldersAreErrors)
{
  const auto open = [](const fs::path& file)
  { return test::errorText<RawlogError>([&] { RawlogReader reader(file); }); };
  EXPECT_NE(open(folder.path() / "none.rawlog").find("no such file"), std::string::npos);
  EXPECT_NE(open(folder.path()).find("not a file"), std::string::npos);
}

TEST_F(RawlogReaderTest, ProgressGrowsToOne)
{
  std::string plain;
  core::Rng rng(1);
  for (int i = 0; i < 500; ++i)
  {
    auto c = comment(i);
    for (int k = 0; k < 2000; ++k) c.text += static_cast<char>(rng.integer(0, 255));
    plain += test::serialized(&c);
  }
  test::writeFile(folder.path() / "a.rawlog", test::gzipped(plain));
  RawlogReader reader(folder.path() / "a.rawlog");
  double before = 0.0;
  while (reader.next())
  {
    EXPECT_GE(reader.progress(), before);
    EXPECT_LE(reader.progress(), 1.0);
    before = reader.progress();
  }
  EXPECT_GT(before, 0.9);
  EXPECT_EQ(reader.progress(), 1.0);
  EXPECT_EQ(reader.next(), nullptr);
}
}  // namespace
