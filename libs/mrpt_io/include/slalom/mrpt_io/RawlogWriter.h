// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/obs/CObservation.h>

#include <filesystem>
#include <memory>

namespace slalom::mrpt_io
{
/// Writes a gzip rawlog in observations format, atomically: the file appears under its name at
/// close(). Byte-identical for identical input. @throws RawlogError when the disk is full, the
/// path cannot be written, or something is there that is not a regular file.
class RawlogWriter
{
 public:
  explicit RawlogWriter(const std::filesystem::path& file, int gzip_level = 6);
  ~RawlogWriter();  ///< discards the partial file if close() was not called
  void write(const mrpt::obs::CObservation& observation);
  void close();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace slalom::mrpt_io
