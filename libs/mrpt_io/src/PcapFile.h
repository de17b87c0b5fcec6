// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace slalom::mrpt_io::detail
{
/// A captured frame; `bytes` is valid until the next call.
struct PcapRecord
{
  double stamp = 0.0;  ///< [s] Unix time
  std::string_view bytes;
  bool whole = true;  ///< false: the capture kept only the beginning of the frame
};

/// Records of a classic pcap file. @throws RawlogError
class PcapFile
{
 public:
  explicit PcapFile(const std::filesystem::path& file);
  /// nullopt at the end. @throws RawlogError when the file is cut or a record is impossible
  [[nodiscard]] std::optional<PcapRecord> next();
  [[nodiscard]] std::uint32_t linkType() const { return link_type_; }

 private:
  [[nodiscard]] std::uint32_t number(const char* bytes) const;
  [[noreturn]] void fail(const std::string& what) const;

  std::filesystem::path path_;
  std::unique_ptr<std::FILE, int (*)(std::FILE*)> file_;
  bool swapped_ = false;
  double fraction_ = 1e-6;  ///< [s] unit of the second half of a time stamp
  std::uint32_t link_type_ = 0;
  std::uint64_t records_ = 0;
  std::vector<char> buffer_;
};

/// The payload of an IPv4 UDP datagram and where it came from.
struct UdpDatagram
{
  std::uint32_t source = 0;  ///< IPv4 address
  std::string_view payload;
};

/// nullopt when the frame holds something else, or a fragment.
[[nodiscard]] std::optional<UdpDatagram> udpOf(std::string_view frame, std::uint32_t link_type);

/// True for link types that udpOf() understands.
[[nodiscard]] bool knownLinkType(std::uint32_t link_type);

}  // namespace slalom::mrpt_io::detail
