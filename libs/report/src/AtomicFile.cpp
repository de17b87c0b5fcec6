// SPDX-License-Identifier: BSD-3-Clause
#include "slalom/report/AtomicFile.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>
#include <utility>

#include "slalom/core/Files.h"

namespace slalom::report
{
namespace
{
constexpr std::size_t kBufferBytes = 64 * 1024;

std::string describeError(const std::filesystem::path& path, std::string_view what, int number)
{
  std::string text = path.string() + ": " + std::string(what);
  if (number != 0) text += ": " + std::generic_category().message(number);
  return text;
}
}  // namespace

OutputError::OutputError(std::filesystem::path path, std::string_view what, int error_number)
    : std::runtime_error(describeError(path, what, error_number)),
      path_(std::move(path)),
      error_number_(error_number)
{
}

AtomicFile::AtomicFile(std::filesystem::path path) : path_(std::move(path)), part_(path_)
{
  if (!core::mayBeReplaced(path_)) throw OutputError(path_, "is in the way: not a regular file");
  part_ += ".part";
  descriptor_ = ::open(part_.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
  if (descriptor_ < 0) throw OutputError(part_, "cannot be opened for writing", errno);
}

AtomicFile::AtomicFile(AtomicFile&& other) noexcept
    : path_(std::move(other.path_)),
      part_(std::move(other.part_)),
      descriptor_(std::exchange(other.descriptor_, -1)),
      error_number_(other.error_number_),
      whole_lines_(other.whole_lines_),
      bytes_on_disk_(other.bytes_on_disk_),
      buffer_(std::move(other.buffer_))
{
}

AtomicFile::~AtomicFile()
{
  if (descriptor_ < 0) return;
  try
  {
    if (error_number_ == 0) flush();
  }
  catch (const OutputError&)
  {
    // Nobody is left to be told; what reached the disk stays in NAME.part.
  }
  closeQuietly();
}

void AtomicFile::fail(std::string_view what)
{
  if (error_number_ == 0) error_number_ = errno;
  buffer_.clear();
  throw OutputError(path_, what, error_number_);
}

void AtomicFile::closeQuietly() noexcept
{
  if (descriptor_ >= 0) ::close(descriptor_);
  descriptor_ = -1;
}

void AtomicFile::write(std::string_view bytes)
{
  if (error_number_ != 0) fail("cannot be written");
  buffer_.append(bytes);
  if (buffer_.size() >= kBufferBytes) flush();
}

void AtomicFile::flush()
{
  if (error_number_ != 0) fail("cannot be written");
  std::size_t done = 0;
  while (done < buffer_.size())
  {
    const ssize_t n = ::write(descriptor_, buffer_.data() + done, buffer_.size() - done);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) fail("cannot be written");
    const std::string_view written(buffer_.data() + done, static_cast<std::size_t>(n));
    if (const auto newline = written.rfind('\n'); newline != std::string_view::npos)
      whole_lines_ = bytes_on_disk_ + newline + 1;
    bytes_on_disk_ += static_cast<std::uint64_t>(n);
    done += static_cast<std::size_t>(n);
  }
  buffer_.clear();
}

void AtomicFile::commit()
{
  if (descriptor_ < 0) return;
  flush();
  const int closed = ::close(std::exchange(descriptor_, -1));
  if (closed != 0) fail("cannot be completed");
  if (std::rename(part_.c_str(), path_.c_str()) != 0) fail("cannot be renamed into place");
}

void AtomicFile::commitWholeLines() noexcept
{
  if (descriptor_ < 0) return;
  const bool cut = ::ftruncate(descriptor_, static_cast<off_t>(whole_lines_)) == 0;
  closeQuietly();
  // If even that fails, the bytes are still there under NAME.part.
  if (cut) std::rename(part_.c_str(), path_.c_str());
}

void writeFileAtomically(const std::filesystem::path& path, std::string_view content)
{
  AtomicFile file(path);
  file.write(content);
  file.commit();
}

}  // namespace slalom::report
