// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/obs/CObservation.h>

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <stdexcept>
#include <string>

namespace slalom::mrpt_io
{
/// The file is unreadable, not a rawlog, or damaged: says where and after how many objects.
/// Programs exit with 3.
class RawlogError : public std::runtime_error
{
 public:
  using std::runtime_error::runtime_error;
};

/// What was seen so far.
struct RawlogStatistics
{
  std::uint64_t objects = 0;
  std::map<std::string, std::uint64_t> observations;  ///< class name -> count
  std::map<std::string, std::uint64_t>
      skipped;  ///< class name or reason -> count (unknown classes, null objects, ...)
};

/** Streams the observations of a rawlog (observations format or sensory-frame format; plain or
 * gzip), in file order, with memory independent of its length. Tells the end of the file apart from
 * damage and never loses an object without a word:
 *   - gzip files are decompressed once before the first object is believed; a checksum or stream
 *     error refuses the file in the constructor;
 *   - a file that was cut, or has foreign bytes behind its end, gives everything before the damage,
 *     then next() throws, and throws again when asked again;
 *   - a plain file has no checksum: flipped data bytes and a cut exactly between two objects cannot
 *     be seen. Its length fields can ask for much memory before reading: call limitMemory().
 * zstd and other archives are refused by name. Objects of unknown classes, null objects and objects
 * that are no observations are skipped and counted; neighbours of unknown classes count as one,
 * because their length is not known.
 *  @throws RawlogError from constructor and next() */
class RawlogReader
{
 public:
  explicit RawlogReader(const std::filesystem::path& file);
  ~RawlogReader();

  /// nullptr at the regular end of the file.
  [[nodiscard]] mrpt::obs::CObservation::Ptr next();

  [[nodiscard]] const RawlogStatistics& statistics() const;
  /// Fraction of the file consumed, in [0, 1].
  [[nodiscard]] double progress() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace slalom::mrpt_io
