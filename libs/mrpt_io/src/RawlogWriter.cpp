// SPDX-License-Identifier: BSD-3-Clause
#include "slalom/mrpt_io/RawlogWriter.h"

#include <fcntl.h>
#include <mrpt/io/CStream.h>
#include <mrpt/serialization/CArchive.h>
#include <unistd.h>
#include <zlib.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <stdexcept>

#include "slalom/core/Files.h"
#include "slalom/mrpt_io/RawlogReader.h"

namespace slalom::mrpt_io
{
namespace
{
std::filesystem::path partial(std::filesystem::path file)
{
  return file += ".part";
}

/// A gzip sink whose errors are not lost on the way through MRPT's archives.
class GzSink : public mrpt::io::CStream
{
 public:
  /// Writes to `partial(file)`; errors name `file`.
  GzSink(const std::filesystem::path& file, int level) : file_(file)
  {
    fd_ = ::open(partial(file).c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
    if (fd_ < 0) fail();
    // zlib closes the descriptor it is given; ours stays open for the final fsync.
    const int own = ::dup(fd_);
    const std::string mode = "wb" + std::to_string(level);
    gz_ = own < 0 ? nullptr : ::gzdopen(own, mode.c_str());
    if (!gz_)
    {
      if (own >= 0) ::close(own);
      ::close(fd_);
      fail();
    }
  }
  ~GzSink() override
  {
    if (gz_) ::gzclose(gz_);
    ::close(fd_);
  }
  GzSink(const GzSink&) = delete;
  GzSink& operator=(const GzSink&) = delete;

  void finish()
  {
    const int result = ::gzclose(gz_);
    gz_ = nullptr;
    if (result != Z_OK || ::fsync(fd_) != 0) fail();
  }

  std::size_t Write(const void* bytes, std::size_t count) override
  {
    const char* at = static_cast<const char*>(bytes);
    for (std::size_t left = count; left > 0;)
    {
      const auto chunk = static_cast<unsigned>(std::min<std::size_t>(left, 1U << 20));
      if (::gzwrite(gz_, at, chunk) != static_cast<int>(chunk)) fail();
      at += chunk;
      left -= chunk;
    }
    position_ += count;
    return count;
  }
  std::size_t Read(void*, std::size_t) override { throw std::logic_error("write-only stream"); }
  std::uint64_t Seek(std::int64_t, TSeekOrigin) override
  {
    throw std::logic_error("stream without seek");
  }
  std::uint64_t getTotalBytesCount() const override { return position_; }
  std::uint64_t getPosition() const override { return position_; }

 private:
  [[noreturn]] void fail() const
  {
    throw RawlogError(file_.string() + ": cannot be written: " + std::strerror(errno));
  }

  std::filesystem::path file_;
  int fd_ = -1;
  gzFile gz_ = nullptr;
  std::uint64_t position_ = 0;
};
}  // namespace

struct RawlogWriter::Impl
{
  Impl(std::filesystem::path f, int level)
      : file(std::move(f)), sink(std::make_unique<GzSink>(file, level))
  {
  }
  std::filesystem::path file;
  std::unique_ptr<GzSink> sink;
};

RawlogWriter::RawlogWriter(const std::filesystem::path& file, int gzip_level)
{
  if (gzip_level < 0 || gzip_level > 9)
    throw std::invalid_argument("gzip level " + std::to_string(gzip_level) + " is not in [0, 9]");
  if (!core::mayBeReplaced(file))
    throw RawlogError(file.string() + ": is in the way: not a regular file");
  impl_ = std::make_unique<Impl>(file, gzip_level);
}

RawlogWriter::~RawlogWriter()
{
  if (!impl_->sink) return;
  impl_->sink.reset();
  std::error_code ignored;
  std::filesystem::remove(partial(impl_->file), ignored);
}

void RawlogWriter::write(const mrpt::obs::CObservation& observation)
{
  if (!impl_->sink) throw std::logic_error("RawlogWriter::write() after close()");
  mrpt::serialization::archiveFrom(*impl_->sink).WriteObject(observation);
}

void RawlogWriter::close()
{
  if (!impl_->sink) return;
  impl_->sink->finish();
  std::error_code error;
  std::filesystem::rename(partial(impl_->file), impl_->file, error);
  if (error) throw RawlogError(impl_->file.string() + ": cannot be written: " + error.message());
  impl_->sink.reset();
}

}  // namespace slalom::mrpt_io
