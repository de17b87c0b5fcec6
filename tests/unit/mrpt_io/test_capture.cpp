// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <mrpt/obs/CObservationGPS.h>

#include <array>
#include <cstdio>
#include <cstring>

#include "ErrorText.h"
#include "Files.h"
#include "Packets.h"
#include "SharedData.h"
#include "slalom/mrpt_io/RawlogReader.h"
#include "slalom/mrpt_io/VelodyneCapture.h"

using namespace slalom;
using mrpt::obs::CObservationGPS;
using mrpt::obs::CObservationVelodyneScan;
using mrpt_io::RawlogError;
using mrpt_io::VelodyneCapture;
using mrpt_io::VelodynePacket;

namespace
{
/// Writes pcap files of any byte order and resolution.
struct Pcap
{
  bool big_endian = false, nano = false;
  std::string bytes;

  Pcap(bool big, bool ns) : big_endian(big), nano(ns)
  {
    number(ns ? 0xa1b23c4d : 0xa1b2c3d4);
    number(big ? 0x00020004 : 0x00040002);
    for (const std::uint32_t v : {0U, 0U, 65535U, 1U}) number(v);
  }
  void number(std::uint32_t v)
  {
    for (int i = 0; i < 4; ++i)
      bytes += static_cast<char>(v >> (big_endian ? 24 - 8 * i : 8 * i) & 0xff);
  }
  void frame(double stamp, const std::string& data, std::size_t kept = 1 << 20)
  {
    const auto seconds = static_cast<std::uint32_t>(stamp);
    number(seconds);
    number(static_cast<std::uint32_t>((stamp - seconds) * (nano ? 1e9 : 1e6) + 0.5));
    number(static_cast<std::uint32_t>(std::min(kept, data.size())));
    number(static_cast<std::uint32_t>(data.size()));
    bytes += data.substr(0, kept);
  }
};

std::string udp(const std::string& payload, char host = '\x21', bool vlan = false)
{
  const auto two = [](std::size_t v) {
    return std::string{static_cast<char>(v >> 8 & 0xff), static_cast<char>(v & 0xff)};
  };
  std::string frame(12, '\x11');
  if (vlan) frame += std::string("\x81\x00\x00\x05", 4);
  frame += std::string("\x08\x00", 2);
  frame += std::string("\x45\x00", 2) + two(28 + payload.size());
  frame += std::string(4, '\0') + "\x40\x11" + two(0);  // not a fragment, time to live, UDP
  frame += std::string("\xc0\xa8\x01", 3) + host + std::string(4, '\xff');
  return frame + two(2368) + two(2368) + two(8 + payload.size()) + two(0) + payload;
}

std::string bytesOf(const VelodynePacket& packet)
{
  return {reinterpret_cast<const char*>(&packet), sizeof(packet)};
}

std::string position(const std::string& sentence)
{
  std::string payload(512, '\0');
  return payload.replace(206, sentence.size() + 2, sentence + "\r\n");
}

std::string nmea(const std::string& body)
{
  unsigned sum = 0;
  for (const char c : body) sum ^= static_cast<unsigned char>(c);
  std::array<char, 8> end{};
  std::snprintf(end.data(), end.size(), "*%02X", sum);
  return "$" + body + end.data();
}

struct Capture : ::testing::Test
{
  std::filesystem::path write(const std::string& bytes)
  {
    const auto file = folder.path() / "a.pcap";
    test::writeFile(file, bytes);
    return file;
  }
  test::TempFolder folder;
};

constexpr double kStart = 1453364282.5;

// Law: the scans' packets, one after the other, are the captured packets; cuts are where the
// azimuth wraps.
TEST_F(Capture, EveryPacketIsInAScanCutAtTheWrap)
{
  for (const bool big : {false, true})
    for (const bool nano : {false, true})
    {
      SCOPED_TRACE(std::to_string(big) + std::to_string(nano));
      core::Rng rng(3);
      const auto packets = test::spin({}, 200, rng);
      Pcap pcap(big, nano);
      for (std::size_t i = 0; i < packets.size(); ++i)
      {
        pcap.frame(kStart + 1.327e-3 * static_cast<double>(i),
                   udp(bytesOf(packets[i]), '\x21', i % 2 == 1));
        if (i % 10 == 0) pcap.frame(kStart, udp("something else"));
        if (i % 10 == 1) pcap.frame(kStart, std::string(60, '\x33'));
      }
      VelodyneCapture capture(write(pcap.bytes));
      std::size_t at = 0;
      int scans = 0;
      while (const auto o = capture.next())
      {
        const auto scan = std::dynamic_pointer_cast<CObservationVelodyneScan>(o);
        ASSERT_TRUE(scan);
        ++scans;
        EXPECT_NEAR(mrpt::Clock::toDouble(scan->timestamp),
                    kStart + 1.327e-3 * static_cast<double>(at), 2e-6);
        for (std::size_t i = 0; i < scan->scan_packets.size(); ++i, ++at)
        {
          ASSERT_LT(at, packets.size());
          EXPECT_EQ(std::memcmp(&scan->scan_packets[i], &packets[at], sizeof(VelodynePacket)), 0);
          if (i > 0)
          {
            EXPECT_GT(packets[at].blocks[0].azimuth, packets[at - 1].blocks[0].azimuth);
          }
        }
      }
      EXPECT_EQ(at, packets.size());
      EXPECT_EQ(scans, 3);  // 123 to 1079 deg
      EXPECT_EQ(capture.statistics().packets, 200U);
      EXPECT_EQ(capture.statistics().skipped.at("not a Velodyne packet"), 40U);
    }
}

TEST_F(Capture, PositionPacketsBecomeOneFixPerNews)
{
  Pcap pcap(false, false);
  const std::string rmc =
      nmea("GPRMC,081803,A,3649.7479,N,00224.4543,W,001.5,270.0,210116,000.5,W,A");
  const std::string gga = nmea("GPGGA,081804,3649.7479,S,00224.4543,E,1,08,0.9,55.5,M,47.2,M,,");
  for (int i = 0; i < 20; ++i) pcap.frame(kStart + 0.01 * i, udp(position(i < 10 ? rmc : gga)));
  std::string wrong = rmc;
  wrong[10] = '9';
  pcap.frame(kStart + 1.0, udp(position(wrong)));
  pcap.frame(kStart + 1.1, udp(position("")));
  VelodyneCapture capture(write(pcap.bytes));
  std::vector<std::shared_ptr<CObservationGPS>> fixes;
  while (const auto o = capture.next())
    fixes.push_back(std::dynamic_pointer_cast<CObservationGPS>(o));
  ASSERT_EQ(fixes.size(), 2U);
  ASSERT_TRUE(fixes[0]->has_RMC_datum());
  const auto& r = fixes[0]->getMsgByClass<mrpt::obs::gnss::Message_NMEA_RMC>().fields;
  EXPECT_NEAR(r.latitude_degrees, 36.8291317, 1e-6);
  EXPECT_NEAR(r.longitude_degrees, -2.4075717, 1e-6);
  EXPECT_EQ(r.validity_char, 'A');
  EXPECT_EQ(r.date_year, 16);
  EXPECT_EQ(r.UTCTime.minute, 18);
  EXPECT_NEAR(r.speed_knots, 1.5, 1e-12);
  ASSERT_TRUE(fixes[1]->has_GGA_datum());
  const auto& g = fixes[1]->getMsgByClass<mrpt::obs::gnss::Message_NMEA_GGA>().fields;
  EXPECT_NEAR(g.latitude_degrees, -36.8291317, 1e-6);
  EXPECT_NEAR(g.altitude_meters, 55.5, 1e-12);
  EXPECT_NEAR(g.HDOP, 0.9, 1e-6);
  EXPECT_EQ(capture.statistics().position_packets, 22U);
  EXPECT_EQ(capture.statistics().skipped.at("position packet without a fix"), 2U);
}

TEST_F(Capture, FollowsOneSensor)
{
  core::Rng rng(4);
  const auto packets = test::spin({}, 10, rng);
  Pcap pcap(false, false);
  for (const auto& packet : packets)
  {
    pcap.frame(kStart, udp(bytesOf(packet), 1));
    pcap.frame(kStart, udp(bytesOf(packet), 2));
  }
  VelodyneCapture capture(write(pcap.bytes));
  while (capture.next())
  {
  }
  EXPECT_EQ(capture.statistics().packets, 10U);
  EXPECT_EQ(capture.statistics().skipped.at("another sensor"), 10U);
}

TEST_F(Capture, ACutCaptureGivesWhatWasBeforeTheCut)
{
  core::Rng rng(5);
  const auto packets = test::spin({}, 100, rng);
  Pcap pcap(false, false);
  for (const auto& packet : packets) pcap.frame(kStart, udp(bytesOf(packet)));
  const std::size_t record = (pcap.bytes.size() - 24) / 100;
  for (std::uint64_t seed = 1; seed <= 30; ++seed)
  {
    SCOPED_TRACE(seed);
    core::Rng cut(seed);
    const auto length =
        static_cast<std::size_t>(cut.integer(25, static_cast<int>(pcap.bytes.size()) - 1));
    VelodyneCapture capture(write(pcap.bytes.substr(0, length)));
    const std::string error = test::errorText<RawlogError>(
        [&]
        {
          while (capture.next())
          {
          }
        });
    EXPECT_EQ(capture.statistics().packets, (length - 24) / record);
    EXPECT_EQ(error == "(no error)", (length - 24) % record == 0) << error;
  }
}

TEST_F(Capture, RefusesWhatIsNotACapture)
{
  const auto open = [&](const std::string& bytes)
  { return test::errorText<RawlogError>([&] { VelodyneCapture capture(write(bytes)); }); };
  EXPECT_NE(open("").find("too short"), std::string::npos);
  EXPECT_NE(open(std::string(100, 'x')).find("not a pcap capture"), std::string::npos);
  EXPECT_NE(open("\x0a\x0d\x0d\x0a" + std::string(100, '\0')).find("editcap"), std::string::npos);
  Pcap serial(false, false);
  serial.bytes[20] = 50;
  EXPECT_NE(open(serial.bytes).find("link type 50"), std::string::npos);
  Pcap impossible(false, false);
  for (int i = 0; i < 4; ++i) impossible.number(0x7fffffff);
  VelodyneCapture capture(write(impossible.bytes));
  EXPECT_THROW((void)capture.next(), RawlogError);
  EXPECT_THROW((void)VelodyneCapture(folder.path() / "none.pcap"), RawlogError);
}

TEST_F(Capture, NoiseNeverCrashes)
{
  core::Rng rng(6);
  const auto packets = test::spin({}, 20, rng);
  Pcap pcap(false, false);
  for (const auto& packet : packets) pcap.frame(kStart, udp(bytesOf(packet)));
  pcap.frame(kStart, udp(position(nmea("GPGGA,,,,,,,,,,,,"))));
  for (std::uint64_t seed = 1; seed <= 200; ++seed)
  {
    SCOPED_TRACE(seed);
    core::Rng noise(seed);
    std::string bytes = pcap.bytes;
    for (int flips = noise.integer(1, 200); flips > 0; --flips)
      bytes[static_cast<std::size_t>(noise.integer(24, static_cast<int>(bytes.size()) - 1))] =
          static_cast<char>(noise.integer(0, 255));
    VelodyneCapture capture(write(bytes));
    try
    {
      while (capture.next())
      {
      }
    }
    catch (const RawlogError&)
    {
    }
  }
}

TEST_F(Capture, RealCaptureHasThePacketsOfItsRawlog)
{
  const auto pcap = test::sharedData("real/vlp16_mrpt_pcap_gps/sample_velodyne_vlp16_gps.pcap");
  const auto rawlog = test::sharedData("real/vlp16_mrpt_pcap_gps/vlp16_gps.rawlog");
  if (!std::filesystem::exists(pcap) || !std::filesystem::exists(rawlog))
    GTEST_SKIP() << pcap << " is absent";
  VelodyneCapture capture(pcap);
  std::string ours, theirs;
  const auto append = [](std::string& all, const mrpt::obs::CObservation::Ptr& o)
  {
    const auto scan = std::dynamic_pointer_cast<CObservationVelodyneScan>(o);
    if (!scan) return;
    for (const auto& packet : scan->scan_packets)
      all.append(reinterpret_cast<const char*>(&packet), sizeof(packet));
  };
  while (const auto o = capture.next()) append(ours, o);
  mrpt_io::RawlogReader reader(rawlog);
  while (const auto o = reader.next()) append(theirs, o);
  EXPECT_EQ(capture.statistics().packets, 293U);
  EXPECT_EQ(capture.statistics().position_packets, 57U);
  EXPECT_EQ(capture.statistics().fixes, 1U);
  // The rawlog leaves out the partial last turn.
  ASSERT_GT(theirs.size(), 270U * sizeof(VelodynePacket));
  EXPECT_EQ(ours.substr(0, theirs.size()), theirs);
}
}  // namespace
