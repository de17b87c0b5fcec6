// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>

#include <cerrno>
#include <csignal>
#include <utility>

#include "TempFolder.h"
#include "slalom/report/AtomicFile.h"
#include "slalom/report/OutputFolder.h"

namespace slalom::report
{
namespace
{
using test::contentOf;
namespace fs = std::filesystem;

/// No file of this process may grow beyond `bytes`: a disk that runs full, without needing one.
class FileSizeLimit
{
 public:
  explicit FileSizeLimit(rlim_t bytes)
  {
    ::getrlimit(RLIMIT_FSIZE, &before_);
    handler_ = std::signal(SIGXFSZ, SIG_IGN);
    rlimit limit = before_;
    limit.rlim_cur = bytes;
    ::setrlimit(RLIMIT_FSIZE, &limit);
  }
  ~FileSizeLimit()
  {
    ::setrlimit(RLIMIT_FSIZE, &before_);
    std::signal(SIGXFSZ, handler_);
  }

 private:
  rlimit before_{};
  void (*handler_)(int) = nullptr;
};

TEST(AtomicFile, AppearsUnderItsNameOnlyWhenComplete)
{
  const test::TempFolder folder;
  const fs::path file = folder / "a.txt";
  writeFileAtomically(file, "old");
  AtomicFile next(file);
  next.write("new");
  next.flush();
  EXPECT_EQ(contentOf(file), "old");
  next.commit();
  EXPECT_EQ(contentOf(file), "new");
  EXPECT_FALSE(fs::exists(folder / "a.txt.part"));
  EXPECT_NO_THROW(next.commit());
}

TEST(AtomicFile, AbandonedFileKeepsItsBytesInPart)
{
  const test::TempFolder folder;
  {
    AtomicFile file(folder / "a.txt");
    file.write("half a fl");
    AtomicFile moved(std::move(file));
    moved.write("ight");
  }
  EXPECT_FALSE(fs::exists(folder / "a.txt"));
  EXPECT_EQ(contentOf(folder / "a.txt.part"), "half a flight");
}

TEST(AtomicFile, UnwritablePlaceNamesPathAndReason)
{
  const test::TempFolder folder;
  writeFileAtomically(folder / "file", "");
  try
  {
    AtomicFile file(folder / "file" / "inside.txt");
    FAIL() << "opened a file inside a file";
  }
  catch (const OutputError& error)
  {
    EXPECT_EQ(error.errorNumber(), ENOTDIR);
    EXPECT_NE(std::string(error.what()).find((folder / "file").string()), std::string::npos);
    EXPECT_NE(std::string(error.what()).find("Not a directory"), std::string::npos);
  }
}

TEST(AtomicFile, LeavesAloneWhatIsNotARegularFile)
{
  const test::TempFolder folder;
  ASSERT_EQ(::mkfifo((folder / "fifo").c_str(), 0600), 0);
  fs::create_symlink("/dev/null", folder / "null");
  fs::create_directory(folder / "sub");
  for (const char* name : {"fifo", "null", "sub"})
  {
    SCOPED_TRACE(name);
    const auto before = fs::symlink_status(folder / name).type();
    try
    {
      writeFileAtomically(folder / name, "x");
      FAIL() << "took the place of something else";
    }
    catch (const OutputError& error)
    {
      EXPECT_EQ(error.path(), folder / name);
      EXPECT_NE(std::string(error.what()).find("not a regular file"), std::string::npos);
    }
    EXPECT_EQ(fs::symlink_status(folder / name).type(), before);
    EXPECT_FALSE(fs::exists(folder / (std::string(name) + ".part")));
  }
}

TEST(AtomicFile, FullDiskIsReportedAndStaysReported)
{
  const test::TempFolder folder;
  if (!fs::exists("/dev/full")) GTEST_SKIP() << "no /dev/full";
  fs::create_symlink("/dev/full", folder / "a.txt.part");
  AtomicFile file(folder / "a.txt");
  file.write("x");
  for (int i = 0; i < 2; ++i)
  {
    try
    {
      file.flush();
      FAIL() << "a full disk took the bytes";
    }
    catch (const OutputError& error)
    {
      EXPECT_EQ(error.errorNumber(), ENOSPC);
      EXPECT_EQ(error.path(), folder / "a.txt");
    }
  }
  EXPECT_THROW(file.write("y"), OutputError);
  EXPECT_THROW(file.commit(), OutputError);
  EXPECT_FALSE(fs::exists(folder / "a.txt"));
}

TEST(AtomicFile, WholeLinesSurviveAFullDisk)
{
  const test::TempFolder folder;
  AtomicFile file(folder / "rows.csv");
  {
    const FileSizeLimit limit(1000);
    EXPECT_THROW(
        {
          for (int i = 0; i < 20000; ++i) file.write("row " + std::to_string(100000 + i) + "\n");
        },
        OutputError);
    EXPECT_THROW(file.commit(), OutputError);
    file.commitWholeLines();
  }
  const std::string kept = contentOf(folder / "rows.csv");
  EXPECT_EQ(kept.size(), 1000u / 11u * 11u);  // 11 bytes per row, none of them cut
  EXPECT_TRUE(kept.ends_with("\n"));
  EXPECT_TRUE(kept.starts_with("row 100000\nrow 100001\n"));
}

TEST(OutputFolder, KeepsAnEarlierReportUnlessTold)
{
  const test::TempFolder folder;
  const fs::path out = folder / "deep/report";
  prepareOutputFolder(out, false);
  EXPECT_NO_THROW(prepareOutputFolder(out, false));  // still empty

  fs::create_directories(out / "cycles");
  writeFileAtomically(out / "metrics.json", "{}");
  writeFileAtomically(out / "cycles/000123.png", "");
  writeFileAtomically(out / "cycles/notes.txt", "mine");
  writeFileAtomically(out / "thesis.tex", "mine too");
  EXPECT_THROW(prepareOutputFolder(out, false), OutputError);
  EXPECT_TRUE(fs::exists(out / "metrics.json"));

  prepareOutputFolder(out, true);
  EXPECT_FALSE(fs::exists(out / "metrics.json"));
  EXPECT_FALSE(fs::exists(out / "cycles/000123.png"));
  EXPECT_TRUE(fs::exists(out / "cycles/notes.txt"));
  EXPECT_TRUE(fs::exists(out / "thesis.tex"));
}

TEST(OutputFolder, RefusesWhatIsNotAFolder)
{
  const test::TempFolder folder;
  writeFileAtomically(folder / "file", "");
  EXPECT_THROW(prepareOutputFolder(folder / "file", true), OutputError);
  EXPECT_THROW(prepareOutputFolder(folder / "file" / "below", true), OutputError);
  EXPECT_EQ(contentOf(folder / "file"), "");
}
}  // namespace
}  // namespace slalom::report
