// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <mrpt/obs/CObservationComment.h>
#include <mrpt/obs/CRawlog.h>
#include <sys/stat.h>
#include <zlib.h>

#include <filesystem>

#include "ErrorText.h"
#include "Files.h"
#include "slalom/mrpt_io/Encoders.h"
#include "slalom/mrpt_io/RawlogReader.h"
#include "slalom/mrpt_io/RawlogWriter.h"

using namespace slalom;
using mrpt_io::RawlogError;
using mrpt_io::RawlogWriter;
namespace fs = std::filesystem;

namespace
{
void writeComments(RawlogWriter& writer, int count)
{
  for (int i = 0; i < count; ++i)
  {
    mrpt::obs::CObservationComment comment;
    comment.timestamp = mrpt::Clock::fromDouble(1.7e9 + i);
    comment.text = "number " + std::to_string(i);
    writer.write(comment);
  }
}

TEST(RawlogWriter, AppearsUnderItsNameAtCloseOnly)
{
  const test::TempFolder folder;
  const fs::path file = folder.path() / "a.rawlog";
  RawlogWriter writer(file);
  writeComments(writer, 10);
  EXPECT_FALSE(fs::exists(file));
  writer.close();
  EXPECT_TRUE(fs::exists(file));
  EXPECT_EQ(folder.count(), 1);
  EXPECT_NO_THROW(writer.close());
  EXPECT_THROW(writeComments(writer, 1), std::logic_error);
}

TEST(RawlogWriter, MrptReadsIt)
{
  const test::TempFolder folder;
  RawlogWriter writer(folder.path() / "a.rawlog");
  for (int i = 0; i < 25; ++i)
    writer.write(*mrpt_io::makeVelocityObservation(1.7e9 + i, Eigen::Vector3d(i, 0, 0)));
  writer.close();
  mrpt::obs::CRawlog rawlog;
  ASSERT_TRUE(rawlog.loadFromRawLogFile((folder.path() / "a.rawlog").string()));
  ASSERT_EQ(rawlog.size(), 25U);
  for (std::size_t i = 0; i < rawlog.size(); ++i)
    EXPECT_NEAR(mrpt::Clock::toDouble(rawlog.getAsObservation(i)->timestamp),
                1.7e9 + static_cast<double>(i), 1e-6);
}

TEST(RawlogWriter, LeavesNothingWhenAbandoned)
{
  const test::TempFolder folder;
  {
    RawlogWriter writer(folder.path() / "a.rawlog");
    writeComments(writer, 10);
  }
  EXPECT_EQ(folder.count(), 0);
}

TEST(RawlogWriter, IsByteIdenticalForIdenticalInput)
{
  const test::TempFolder folder;
  for (const char* name : {"a.rawlog", "b.rawlog"})
  {
    RawlogWriter writer(folder.path() / name);
    writeComments(writer, 100);
    writer.close();
  }
  EXPECT_EQ(test::contents(folder.path() / "a.rawlog"), test::contents(folder.path() / "b.rawlog"));
}

TEST(RawlogWriter, ErrorsNameTheFile)
{
  const test::TempFolder folder;
  const auto open = [&](const fs::path& file)
  { return test::errorText<RawlogError>([&] { RawlogWriter writer(file); }); };
  EXPECT_NE(open(folder.path() / "no/such/a.rawlog").find("a.rawlog"), std::string::npos);
  EXPECT_THROW(RawlogWriter(folder.path() / "a.rawlog", 11), std::invalid_argument);
}

TEST(RawlogWriter, LeavesAloneWhatIsNotARegularFile)
{
  const test::TempFolder folder;
  const fs::path fifo = folder.path() / "fifo.rawlog", null = folder.path() / "null.rawlog",
                 sub = folder.path() / "sub.rawlog";
  ASSERT_EQ(::mkfifo(fifo.c_str(), 0600), 0);
  fs::create_symlink("/dev/null", null);
  fs::create_directory(sub);
  for (const fs::path& file : {fifo, null, sub})
  {
    SCOPED_TRACE(file);
    const auto before = fs::symlink_status(file).type();
    const std::string text = test::errorText<RawlogError>([&] { RawlogWriter writer(file); });
    EXPECT_NE(text.find(file.string()), std::string::npos) << text;
    EXPECT_NE(text.find("not a regular file"), std::string::npos) << text;
    EXPECT_EQ(fs::symlink_status(file).type(), before);
  }
  EXPECT_EQ(folder.count(), 3);
}

TEST(RawlogWriter, AFullDiskIsAnError)
{
  if (!fs::exists("/dev/full")) GTEST_SKIP() << "no /dev/full";
  const test::TempFolder folder;
  fs::create_symlink("/dev/full", folder.path() / "a.rawlog.part");
  const std::string text = test::errorText<RawlogError>(
      [&]
      {
        RawlogWriter writer(folder.path() / "a.rawlog");
        writeComments(writer, 10);
        writer.close();
      });
  EXPECT_NE(text.find("No space left"), std::string::npos) << text;
  EXPECT_FALSE(fs::exists(folder.path() / "a.rawlog"));
}
}  // namespace
