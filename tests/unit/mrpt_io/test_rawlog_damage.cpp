// SPDX-License-Identifier: BSD-3-Clause
// Damaged rawlogs: no crash, and nothing is lost without a word.
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>

#include "ErrorText.h"
#include "Rawlogs.h"
#include "slalom/core/Rng.h"
#include "slalom/mrpt_io/Encoders.h"
#include "slalom/mrpt_io/MemoryLimit.h"

using namespace slalom;
namespace fs = std::filesystem;

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool kSanitized = true;
#else
constexpr bool kSanitized = false;
#endif

#if defined(__SANITIZE_ADDRESS__)
/// MRPT 2.5.8 loses a GPS message (some 80 bytes) when the stream ends inside it.
extern "C" const char* __lsan_default_suppressions()
{
  return "leak:mrpt::obs::gnss::gnss_message::Factory\n";
}
#endif

namespace
{
struct RawlogDamage : ::testing::Test
{
  void SetUp() override
  {
    core::Rng rng(7);
    std::vector<mrpt_io::VelodynePacket> packets(3);
    for (auto& packet : packets)
      for (auto& block : packet.blocks)
        for (auto& r : block.returns)
          r.distance = static_cast<std::uint16_t>(rng.integer(0, 60000));
    const mrpt_io::EnuFrame frame(Eigen::Vector3d(36.8, -2.4, 50.0));
    for (int i = 0; i < 12; ++i)
    {
      const double t = 1.7e9 + 0.1 * i;
      core::ImuSample imu;
      imu.f_B = rng.normal3(5.0);
      add(mrpt_io::makeImuObservation(t, imu));
      add(mrpt_io::makeGpsObservation(t, {.p_W = rng.normal3(10.0), .v_W = rng.normal3(1.0)},
                                      frame));
      add(mrpt_io::makePoseObservation(t, {}, "POSE"));
      add(mrpt_io::makeVelodyneObservation(t, packets, Eigen::Isometry3d::Identity()));
    }
  }
  void add(const mrpt_io::ObservationPtr& o)
  {
    objects.push_back(test::serialized(o.get()));
    plain += objects.back();
  }
  test::Reading read(const std::string& bytes)
  {
    test::writeFile(folder.path() / "a.rawlog", bytes);
    return test::readAll(folder.path() / "a.rawlog");
  }
  void expectPrefix(const test::Reading& reading)
  {
    ASSERT_LE(reading.objects.size(), objects.size());
    EXPECT_TRUE(std::equal(reading.objects.begin(), reading.objects.end(), objects.begin()));
  }

  test::TempFolder folder;
  std::string plain;
  std::vector<std::string> objects;
};

TEST_F(RawlogDamage, ACutGzipFileGivesWhatWasBeforeTheCutAndThenAnError)
{
  const std::string whole = test::gzipped(plain);
  ASSERT_EQ(read(whole).objects.size(), objects.size());
  std::size_t most = 0;
  for (std::uint64_t seed = 1; seed <= 70; ++seed)
  {
    SCOPED_TRACE(seed);
    core::Rng rng(seed);
    const int last = static_cast<int>(whole.size()) - 1;
    // Every cut of the last bytes (the checksum) and random cuts elsewhere.
    const int length = seed <= 10 ? last - static_cast<int>(seed) + 1 : rng.integer(0, last);
    const test::Reading reading = read(whole.substr(0, static_cast<std::size_t>(length)));
    EXPECT_NE(reading.error, "") << "silent loss at " << length;
    expectPrefix(reading);
    most = std::max(most, reading.objects.size());
  }
  EXPECT_EQ(most, objects.size()) << "a cut in the checksum must not cost an object";
}

TEST_F(RawlogDamage, AFlippedBitInAGzipFileIsRefusedOrHarmless)
{
  const std::string whole = test::gzipped(plain);
  int refused = 0;
  for (std::uint64_t seed = 1; seed <= 70; ++seed)
  {
    SCOPED_TRACE(seed);
    core::Rng rng(seed);
    std::string mutant = whole;
    const auto at = static_cast<std::size_t>(rng.integer(0, static_cast<int>(whole.size()) - 1));
    mutant[at] = static_cast<char>(mutant[at] ^ (1 << rng.integer(0, 7)));
    const test::Reading reading = read(mutant);
    if (reading.error.empty())
      EXPECT_EQ(reading.objects, objects) << "silent damage at " << at;
    else
      expectPrefix(reading);
    refused += reading.refused;
  }
  EXPECT_GT(refused, 60);
}

TEST_F(RawlogDamage, ForeignBytesAfterTheEndAreTold)
{
  const test::Reading reading = read(test::gzipped(plain) + "garbage");
  EXPECT_EQ(reading.objects, objects);
  EXPECT_NE(reading.error.find("foreign bytes"), std::string::npos) << reading.error;
}

TEST_F(RawlogDamage, ACutPlainFileGivesWhatWasBeforeTheCut)
{
  for (std::uint64_t seed = 1; seed <= 60; ++seed)
  {
    SCOPED_TRACE(seed);
    core::Rng rng(seed);
    const int length = rng.integer(1, static_cast<int>(plain.size()) - 1);
    const test::Reading reading = read(plain.substr(0, static_cast<std::size_t>(length)));
    expectPrefix(reading);
    std::size_t good = 0, end = 0;
    while (end + objects[good].size() <= static_cast<std::size_t>(length))
      end += objects[good++].size();
    EXPECT_EQ(reading.objects.size(), good);
    // The plain format cannot tell a cut between two objects from the end.
    EXPECT_EQ(reading.error.empty(), end == static_cast<std::size_t>(length));
  }
}

TEST_F(RawlogDamage, TheErrorStays)
{
  test::writeFile(folder.path() / "a.rawlog", plain.substr(0, plain.size() / 2 + 1));
  mrpt_io::RawlogReader reader(folder.path() / "a.rawlog");
  const auto drain = [&]
  {
    while (reader.next())
    {
    }
  };
  const std::string first = test::errorText<mrpt_io::RawlogError>(drain);
  EXPECT_NE(first.find("damaged"), std::string::npos) << first;
  EXPECT_EQ(first.find('\n'), std::string::npos) << first;
  EXPECT_EQ(test::errorText<mrpt_io::RawlogError>(drain), first);
}

/// Runs `action` in a child with 1 GB of address space; true when it returned normally.
template <class Action>
bool survives(Action action)
{
  const pid_t child = ::fork();
  if (child == 0)
  {
    mrpt_io::limitMemory(std::uint64_t(1) << 30);
    action();
    ::_exit(0);
  }
  int status = -1;
  ::waitpid(child, &status, 0);
  return WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

TEST_F(RawlogDamage, FlippedBitsInAPlainFileNeverCrash)
{
  if (kSanitized) GTEST_SKIP() << "address space cannot be limited under a sanitizer";
  for (std::uint64_t seed = 1; seed <= 100; ++seed)
  {
    SCOPED_TRACE(seed);
    core::Rng rng(seed);
    std::string mutant = plain;
    for (int flips = rng.integer(1, 4); flips > 0; --flips)
    {
      const auto at = static_cast<std::size_t>(rng.integer(0, static_cast<int>(plain.size()) - 1));
      mutant[at] = static_cast<char>(mutant[at] ^ (1 << rng.integer(0, 7)));
    }
    EXPECT_TRUE(survives([&] { (void)read(mutant); }));
  }
}

TEST_F(RawlogDamage, AHugeLengthFieldIsAnErrorNotAnExhaustedMachine)
{
  if (kSanitized) GTEST_SKIP() << "address space cannot be limited under a sanitizer";
  // The packet count of the first scan stands right behind its range limits.
  std::string mutant = plain;
  const std::size_t scan = mutant.find("CObservationVelodyneScan");
  ASSERT_NE(scan, std::string::npos);
  for (std::size_t at = scan + 25; at < scan + 185; at += 4)
  {
    SCOPED_TRACE(at);
    mutant = plain;
    mutant.replace(at, 4, "\xff\xff\xff\x7f");
    EXPECT_TRUE(survives([&] { (void)read(mutant); }));
  }
}
}  // namespace
