// SPDX-License-Identifier: BSD-3-Clause
#include "ByteSource.h"

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "slalom/mrpt_io/RawlogReader.h"

namespace slalom::mrpt_io::detail
{
namespace
{
constexpr std::size_t kInput = 1 << 16;
constexpr int kGzipOnly = 16 + MAX_WBITS;
}  // namespace

ByteSource::ByteSource(const std::filesystem::path& file) : file_(nullptr, &std::fclose)
{
  std::error_code error;
  if (!std::filesystem::exists(file, error)) throw RawlogError(file.string() + ": no such file");
  if (!std::filesystem::is_regular_file(file, error))
    throw RawlogError(file.string() + ": not a file");
  size_ = std::filesystem::file_size(file, error);
  file_.reset(std::fopen(file.c_str(), "rb"));
  if (!file_) throw RawlogError(file.string() + ": cannot be read: " + std::strerror(errno));
  input_.resize(kInput);
  refill();
  magic_.assign(reinterpret_cast<const char*>(input_.data()), std::min<std::size_t>(pending_, 8));
  compressed_ = magic_.starts_with("\x1f\x8b");
  if (compressed_ && ::inflateInit2(&zlib_, kGzipOnly) != Z_OK)
    throw RawlogError(file.string() + ": zlib cannot start");
  zlib_.next_in = input_.data();
}

ByteSource::~ByteSource()
{
  if (compressed_) ::inflateEnd(&zlib_);
}

void ByteSource::spoil(Damage damage, const std::string& what)
{
  damage_ = damage;
  ended_ = true;
  complaint_ = what + " at byte " + std::to_string(fileOffset()) + " of " + std::to_string(size_);
}

bool ByteSource::refill()
{
  pending_ = std::fread(input_.data(), 1, input_.size(), file_.get());
  offset_ += pending_;
  zlib_.next_in = input_.data();
  if (pending_ == 0 && std::ferror(file_.get()))
    spoil(Damage::Io, std::string("read error: ") + std::strerror(errno));
  return pending_ > 0;
}

std::size_t ByteSource::read(void* bytes, std::size_t count)
{
  auto* out = static_cast<std::uint8_t*>(bytes);
  std::size_t done = 0;
  while (done < count && !ended_)
  {
    if (pending_ == 0 && !refill())
    {
      if (compressed_ && damage_ == Damage::None) spoil(Damage::Cut, "the file ends too early");
      ended_ = true;
      break;
    }
    if (compressed_)
    {
      done += inflateInto(out + done, count - done);
      continue;
    }
    const std::size_t n = std::min(pending_, count - done);
    std::memcpy(out + done, zlib_.next_in, n);
    zlib_.next_in += n;
    pending_ -= n;
    done += n;
  }
  return done;
}

std::size_t ByteSource::inflateInto(std::uint8_t* bytes, std::size_t count)
{
  zlib_.avail_in = static_cast<unsigned>(pending_);
  zlib_.next_out = bytes;
  zlib_.avail_out = static_cast<unsigned>(std::min<std::size_t>(count, 1U << 30));
  const unsigned wanted = zlib_.avail_out;
  const int status = ::inflate(&zlib_, Z_NO_FLUSH);
  pending_ = zlib_.avail_in;
  if (status == Z_STREAM_END)
    ended_ = !nextMember();
  else if (status != Z_OK && status != Z_BUF_ERROR)
    spoil(Damage::Corrupt,
          std::string("gzip data is corrupt (") + (zlib_.msg ? zlib_.msg : "no detail") + ")");
  return wanted - zlib_.avail_out;
}

/// gzip files may be concatenated; anything else after the end is not ours to skip silently.
bool ByteSource::nextMember()
{
  if (pending_ == 0 && !refill()) return false;
  if (*zlib_.next_in != 0x1f)
  {
    spoil(Damage::Cut, "foreign bytes after the end of the gzip data");
    return false;
  }
  return ::inflateReset2(&zlib_, kGzipOnly) == Z_OK;
}

}  // namespace slalom::mrpt_io::detail
