// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/io/CStream.h>

#include <string>
#include <vector>

#include "ByteSource.h"

namespace slalom::mrpt_io::detail
{
/// The name in the header of a serialized object.
struct ObjectHeader
{
  std::string class_name;
  std::size_t size = 0;  ///< bytes of the header, without the version byte; 0 = not a header
};

/** A ByteSource as an MRPT stream that can look ahead. A read that cannot be satisfied throws: MRPT
 * itself takes a short read for success. */
class ObjectStream : public mrpt::io::CStream
{
 public:
  explicit ObjectStream(const std::filesystem::path& file) : source_(file) {}

  [[nodiscard]] const ByteSource& source() const { return source_; }
  /// Fewer than `count` bytes only at the end. Valid until the next call.
  [[nodiscard]] std::string_view peek(std::size_t count);
  void skip(std::size_t count);

  /// The header at the current position (formats since MRPT 0.5.5).
  [[nodiscard]] ObjectHeader peekHeader();
  /** Moves behind an object of unknown class and length: to the next end-of-object mark that is
   * followed by the header of a class that may stand at the top of a rawlog, or to the end.
   *  @return bytes skipped */
  std::uint64_t skipUnknownObject();

  std::size_t Read(void* bytes, std::size_t count) override;
  std::size_t Write(const void*, std::size_t) override;
  std::uint64_t Seek(std::int64_t, TSeekOrigin) override;
  std::uint64_t getTotalBytesCount() const override { return source_.fileSize(); }
  std::uint64_t getPosition() const override { return position_; }

 private:
  ByteSource source_;
  std::vector<char> buffer_;
  std::size_t begin_ = 0, end_ = 0;
  std::uint64_t position_ = 0;
};

/// Reads a header from the beginning of `bytes`; size 0 when there is none.
[[nodiscard]] ObjectHeader parseHeader(std::string_view bytes);

}  // namespace slalom::mrpt_io::detail
