// SPDX-License-Identifier: BSD-3-Clause
#include "ObjectStream.h"

#include <mrpt/rtti/CObject.h>

#include <algorithm>
#include <cctype>
#include <cstring>
#include <stdexcept>

namespace slalom::mrpt_io::detail
{
namespace
{
constexpr std::size_t kLongestName = 120;  // MRPT refuses longer ones
constexpr char kEndOfObject = '\x88';
constexpr std::size_t kBuffer = 1 << 16;

bool mayStartRecord(const std::string& class_name)
{
  for (const char* part : {"CObservation", "CSensoryFrame", "CActionCollection"})
    if (class_name.find(part) != std::string::npos)
      return mrpt::rtti::findRegisteredClass(class_name) != nullptr;
  return false;
}
}  // namespace

ObjectHeader parseHeader(std::string_view bytes)
{
  if (bytes.empty() || !(bytes[0] & 0x80)) return {};
  const auto length = static_cast<std::size_t>(bytes[0] & 0x7f);
  if (length == 0 || length > kLongestName || bytes.size() < length + 1) return {};
  const std::string_view name = bytes.substr(1, length);
  const auto allowed = [](unsigned char c)
  { return std::isalnum(c) || std::strchr("_:<>, ", c) != nullptr; };
  if (!std::all_of(name.begin(), name.end(), allowed)) return {};
  return {std::string(name), length + 1};
}

std::string_view ObjectStream::peek(std::size_t count)
{
  if (end_ - begin_ < count)
  {
    buffer_.resize(std::max(kBuffer, count));
    std::memmove(buffer_.data(), buffer_.data() + begin_, end_ - begin_);
    end_ -= begin_;
    begin_ = 0;
    end_ += source_.read(buffer_.data() + end_, buffer_.size() - end_);
  }
  return {buffer_.data() + begin_, std::min(count, end_ - begin_)};
}

void ObjectStream::skip(std::size_t count)
{
  count = peek(count).size();
  begin_ += count;
  position_ += count;
}

ObjectHeader ObjectStream::peekHeader()
{
  return parseHeader(peek(kLongestName + 1));
}

std::uint64_t ObjectStream::skipUnknownObject()
{
  const std::uint64_t start = position_;
  skip(peekHeader().size);
  for (;;)
  {
    (void)peek(kLongestName + 2);
    const std::string_view ahead(buffer_.data() + begin_, end_ - begin_);
    if (ahead.empty()) return position_ - start;
    const std::size_t mark = ahead.find(kEndOfObject);
    skip(mark == std::string_view::npos ? ahead.size() : mark + 1);
    if (mark == std::string_view::npos) continue;
    // "nullptr" and unknown classes may follow as well, but only known names are proof.
    const ObjectHeader header = peekHeader();
    if (peek(1).empty() || (header.size > 0 && mayStartRecord(header.class_name)))
      return position_ - start;
  }
}

std::size_t ObjectStream::Read(void* bytes, std::size_t count)
{
  auto* out = static_cast<char*>(bytes);
  const std::size_t buffered = std::min(count, end_ - begin_);
  std::memcpy(out, buffer_.data() + begin_, buffered);
  begin_ += buffered;
  const std::size_t direct = source_.read(out + buffered, count - buffered);
  position_ += buffered + direct;
  if (buffered + direct < count) throw std::runtime_error("the data end inside an object");
  return count;
}

std::size_t ObjectStream::Write(const void*, std::size_t)
{
  throw std::logic_error("read-only stream");
}

std::uint64_t ObjectStream::Seek(std::int64_t, TSeekOrigin)
{
  throw std::logic_error("stream without seek");
}

}  // namespace slalom::mrpt_io::detail
