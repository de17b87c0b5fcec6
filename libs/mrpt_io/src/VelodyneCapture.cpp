// SPDX-License-Identifier: BSD-3-Clause
#include "slalom/mrpt_io/VelodyneCapture.h"

#include <mrpt/obs/CObservationGPS.h>

#include <cstring>
#include <deque>
#include <optional>
#include <set>
#include <vector>

#include "Nmea.h"
#include "PcapFile.h"
#include "slalom/mrpt_io/Encoders.h"
#include "slalom/mrpt_io/RawlogReader.h"
#include "slalom/mrpt_io/Velodyne.h"

namespace slalom::mrpt_io
{
namespace
{
constexpr std::size_t kPositionPacket = 512, kNmeaOffset = 206;
constexpr double kLongestPause = 0.5;       // [s] between two packets of one turn
constexpr std::size_t kMostPackets = 2000;  // a sensor that does not turn must not fill the memory
constexpr int kHalfTurn = 18000;            // [0.01 deg]
}  // namespace

struct VelodyneCapture::Impl
{
  Impl(const std::filesystem::path& f, CaptureOptions o) : file(f), options(std::move(o)), pcap(f)
  {
    if (!detail::knownLinkType(pcap.linkType()))
      throw RawlogError(f.string() + ": link type " + std::to_string(pcap.linkType()) +
                        " is neither Ethernet nor IP");
  }

  void take(const detail::PcapRecord& record);
  // Both tell whether the payload is what its size promises.
  bool takeData(double stamp, std::string_view payload);
  bool takePosition(double stamp, std::string_view payload);
  void finishScan();

  std::filesystem::path file;
  CaptureOptions options;
  detail::PcapFile pcap;
  CaptureStatistics statistics;
  std::optional<std::uint32_t> sensor;
  std::vector<VelodynePacket> packets;
  double first_stamp = 0.0, last_stamp = 0.0;
  std::set<std::string> sentences;  ///< last news of each kind: they are sent again and again
  std::deque<ObservationPtr> fixes, ready;  ///< fixes wait for the scan that began before them
  std::string failure;
  bool ended = false;
};

VelodyneCapture::VelodyneCapture(const std::filesystem::path& file, CaptureOptions options)
    : impl_(std::make_unique<Impl>(file, std::move(options)))
{
}

VelodyneCapture::~VelodyneCapture() = default;

mrpt::obs::CObservation::Ptr VelodyneCapture::next()
{
  while (impl_->ready.empty())
  {
    if (!impl_->failure.empty()) throw RawlogError(impl_->failure);
    if (impl_->ended) return nullptr;
    try
    {
      const auto record = impl_->pcap.next();
      if (record)
        impl_->take(*record);
      else
        impl_->ended = true;
    }
    catch (const RawlogError& e)
    {
      // What was captured before the damage is delivered first.
      impl_->failure = e.what();
    }
    if (impl_->ended || !impl_->failure.empty()) impl_->finishScan();
  }
  auto observation = impl_->ready.front();
  impl_->ready.pop_front();
  return observation;
}

const CaptureStatistics& VelodyneCapture::statistics() const
{
  return impl_->statistics;
}

void VelodyneCapture::Impl::take(const detail::PcapRecord& record)
{
  if (!record.whole)
  {
    ++statistics.skipped["frame captured in part"];
    return;
  }
  const auto datagram = detail::udpOf(record.bytes, pcap.linkType());
  const bool data = datagram && datagram->payload.size() == sizeof(VelodynePacket);
  const bool position = datagram && datagram->payload.size() == kPositionPacket;
  if (!data && !position)
    ++statistics.skipped["not a Velodyne packet"];
  else if (sensor && *sensor != datagram->source)
    ++statistics.skipped["another sensor"];
  else if (data ? takeData(record.stamp, datagram->payload)
                : takePosition(record.stamp, datagram->payload))
    sensor = datagram->source;
}

bool VelodyneCapture::Impl::takeData(double stamp, std::string_view payload)
{
  VelodynePacket packet;
  std::memcpy(&packet, payload.data(), sizeof(packet));
  const auto& first = packet.blocks[0];
  if ((first.header != 0xEEFF && first.header != 0xDDFF) || first.azimuth >= 36000)
  {
    ++statistics.skipped["not a Velodyne packet"];
    return false;
  }
  if (!packets.empty())
  {
    const bool turned = packets.back().blocks[0].azimuth - first.azimuth > kHalfTurn;
    const bool paused = std::abs(stamp - last_stamp) > kLongestPause;
    if (turned || paused || packets.size() >= kMostPackets) finishScan();
  }
  if (packets.empty()) first_stamp = stamp;
  packets.push_back(packet);
  last_stamp = stamp;
  ++statistics.packets;
  return true;
}

bool VelodyneCapture::Impl::takePosition(double stamp, std::string_view payload)
{
  ++statistics.position_packets;
  auto gps = std::make_shared<mrpt::obs::CObservationGPS>();
  std::string_view text = payload.substr(kNmeaOffset);
  text = text.substr(0, text.find('\0'));
  std::set<std::string> now;
  while (!text.empty())
  {
    const std::size_t end = text.find_first_of("\r\n");
    const std::string_view sentence = text.substr(0, end);
    if (detail::readNmea(sentence, *gps)) now.emplace(sentence);
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
  }
  if (now.empty()) ++statistics.skipped["position packet without a fix"];
  if (now.empty() || now == sentences) return !now.empty();
  sentences = std::move(now);
  gps->timestamp = mrpt::Clock::fromDouble(stamp);
  gps->originalReceivedTimestamp = gps->timestamp;
  gps->sensorLabel = options.gps_label;
  fixes.push_back(gps);
  ++statistics.fixes;
  if (packets.empty()) finishScan();
  return true;
}

void VelodyneCapture::Impl::finishScan()
{
  if (!packets.empty())
  {
    ready.push_back(
        makeVelodyneObservation(first_stamp, packets, options.T_BS, options.scan_label));
    ++statistics.scans;
    packets.clear();
  }
  ready.insert(ready.end(), fixes.begin(), fixes.end());
  fixes.clear();
}

}  // namespace slalom::mrpt_io
