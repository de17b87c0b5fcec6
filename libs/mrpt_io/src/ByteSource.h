// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <zlib.h>

#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

namespace slalom::mrpt_io::detail
{
/** The bytes of a file, decompressed when it is gzip. Unlike gzread() it keeps the end of the data,
 * a cut file, a damaged stream and foreign bytes after the end apart, and remembers which it was.
 */
class ByteSource
{
 public:
  enum class Damage
  {
    None,
    Cut,  ///< the file ends inside the gzip stream, or foreign bytes follow it; all bytes before
          ///< are good as far as one can tell
    Corrupt,  ///< the stream contradicts itself or its checksum; no byte can be trusted
    Io        ///< the operating system could not read
  };

  /// @throws RawlogError when the file cannot be opened
  explicit ByteSource(const std::filesystem::path& file);
  ~ByteSource();
  ByteSource(const ByteSource&) = delete;
  ByteSource& operator=(const ByteSource&) = delete;

  /// Up to `count` bytes; 0 at the end or at damage.
  std::size_t read(void* bytes, std::size_t count);

  [[nodiscard]] bool compressed() const { return compressed_; }
  [[nodiscard]] Damage damage() const { return damage_; }
  /// What is wrong and at which byte of the file; "" when nothing is.
  [[nodiscard]] const std::string& complaint() const { return complaint_; }
  [[nodiscard]] std::uint64_t fileOffset() const { return offset_ - pending_; }
  [[nodiscard]] std::uint64_t fileSize() const { return size_; }
  /// First bytes of the file as they are on disk.
  [[nodiscard]] const std::string& magic() const { return magic_; }

 private:
  bool refill();
  std::size_t inflateInto(std::uint8_t* bytes, std::size_t count);
  bool nextMember();
  void spoil(Damage damage, const std::string& what);

  std::unique_ptr<std::FILE, int (*)(std::FILE*)> file_;
  std::uint64_t size_ = 0, offset_ = 0;
  std::size_t pending_ = 0;
  std::vector<std::uint8_t> input_;
  std::string magic_, complaint_;
  z_stream zlib_{};
  bool compressed_ = false, ended_ = false;
  Damage damage_ = Damage::None;
};

}  // namespace slalom::mrpt_io::detail
