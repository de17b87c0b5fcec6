// SPDX-License-Identifier: BSD-3-Clause
// Formats: "PCAP capture file format" (IETF opsawg draft), RFC 791 (IPv4), RFC 768 (UDP).
#include "PcapFile.h"

#include <array>
#include <cerrno>
#include <cstring>

#include "slalom/mrpt_io/RawlogReader.h"

namespace slalom::mrpt_io::detail
{
namespace
{
constexpr std::uint32_t kMicro = 0xa1b2c3d4, kNano = 0xa1b23c4d, kNextGeneration = 0x0a0d0d0a;
constexpr std::uint32_t kLargestFrame = 1 << 18;
constexpr std::uint32_t kEthernet = 1, kRaw = 101, kRawOld = 12, kIpv4 = 228, kCooked = 113;
constexpr std::uint16_t kTypeIpv4 = 0x0800, kTypeVlan = 0x8100, kTypeQinq = 0x88a8;
constexpr std::uint8_t kUdp = 17;

std::uint32_t reversed(std::uint32_t v)
{
  return (v >> 24) | ((v >> 8) & 0xff00) | ((v << 8) & 0xff0000) | (v << 24);
}

std::uint8_t byteAt(std::string_view s, std::size_t i)
{
  return static_cast<std::uint8_t>(s[i]);
}

std::uint16_t networkShort(std::string_view s, std::size_t i)
{
  return static_cast<std::uint16_t>(byteAt(s, i) << 8 | byteAt(s, i + 1));
}

/// The IPv4 packet inside an Ethernet or cooked frame, or nothing.
std::string_view ipv4Of(std::string_view frame, std::uint32_t link_type)
{
  if (link_type == kRaw || link_type == kRawOld || link_type == kIpv4) return frame;
  std::size_t type_at = link_type == kCooked ? 14 : 12;
  for (int tags = 0; tags < 3; ++tags, type_at += 4)
  {
    if (frame.size() < type_at + 2) return {};
    const std::uint16_t type = networkShort(frame, type_at);
    if (type == kTypeIpv4) return frame.substr(type_at + 2);
    if (type != kTypeVlan && type != kTypeQinq) return {};
  }
  return {};
}
}  // namespace

PcapFile::PcapFile(const std::filesystem::path& file) : path_(file), file_(nullptr, &std::fclose)
{
  std::error_code error;
  if (!std::filesystem::exists(file, error)) throw RawlogError(file.string() + ": no such file");
  if (!std::filesystem::is_regular_file(file, error))
    throw RawlogError(file.string() + ": not a file");
  file_.reset(std::fopen(file.c_str(), "rb"));
  if (!file_) throw RawlogError(file.string() + ": cannot be read: " + std::strerror(errno));
  std::array<char, 24> header{};
  if (std::fread(header.data(), 1, header.size(), file_.get()) != header.size())
    throw RawlogError(file.string() + ": not a pcap capture: too short");
  std::uint32_t magic = number(header.data());
  if (magic == kNextGeneration)
    throw RawlogError(file.string() +
                      ": a pcapng capture; convert it: editcap -F pcap in.pcapng out.pcap");
  swapped_ = magic != kMicro && magic != kNano;
  magic = number(header.data());
  if (magic != kMicro && magic != kNano) throw RawlogError(file.string() + ": not a pcap capture");
  if (magic == kNano) fraction_ = 1e-9;
  link_type_ = number(header.data() + 20) & 0x0fffffff;
}

std::uint32_t PcapFile::number(const char* bytes) const
{
  std::uint32_t value = 0;
  std::memcpy(&value, bytes, sizeof(value));
  return swapped_ ? reversed(value) : value;
}

void PcapFile::fail(const std::string& what) const
{
  throw RawlogError(path_.string() + ": damaged: " + what + "; " + std::to_string(records_) +
                    " frames before it are good");
}

std::optional<PcapRecord> PcapFile::next()
{
  std::array<char, 16> header{};
  const std::size_t got = std::fread(header.data(), 1, header.size(), file_.get());
  if (got == 0 && !std::ferror(file_.get())) return std::nullopt;
  if (got != header.size()) fail("the file ends inside a record");
  const std::uint32_t kept = number(header.data() + 8), sent = number(header.data() + 12);
  if (kept > kLargestFrame) fail("a frame of " + std::to_string(kept) + " bytes");
  buffer_.resize(kept);
  if (std::fread(buffer_.data(), 1, kept, file_.get()) != kept)
    fail("the file ends inside a record");
  ++records_;
  return PcapRecord{number(header.data()) + fraction_ * number(header.data() + 4),
                    {buffer_.data(), kept},
                    kept >= sent};
}

bool knownLinkType(std::uint32_t t)
{
  return t == kEthernet || t == kRaw || t == kRawOld || t == kIpv4 || t == kCooked;
}

std::optional<UdpDatagram> udpOf(std::string_view frame, std::uint32_t link_type)
{
  const std::string_view ip = ipv4Of(frame, link_type);
  if (ip.size() < 20 || byteAt(ip, 0) >> 4 != 4 || byteAt(ip, 9) != kUdp) return std::nullopt;
  const std::size_t header = 4U * (byteAt(ip, 0) & 0x0f);
  const bool fragment = (networkShort(ip, 6) & 0x3fff) != 0;
  if (header < 20 || fragment || ip.size() < header + 8) return std::nullopt;
  const std::size_t length = networkShort(ip, header + 4);
  if (length < 8 || ip.size() < header + length) return std::nullopt;
  const std::uint32_t source =
      static_cast<std::uint32_t>(networkShort(ip, 12)) << 16 | networkShort(ip, 14);
  return UdpDatagram{source, ip.substr(header + 8, length - 8)};
}

}  // namespace slalom::mrpt_io::detail
