// SPDX-License-Identifier: BSD-3-Clause
#include "slalom/mrpt_io/RawlogReader.h"

#include <mrpt/io/lazy_load_path.h>
#include <mrpt/maps/registerAllClasses.h>
#include <mrpt/obs/CSensoryFrame.h>
#include <mrpt/obs/registerAllClasses.h>
#include <mrpt/serialization/CArchive.h>

#include <algorithm>
#include <deque>
#include <new>
#include <vector>

#include "MrptError.h"
#include "ObjectStream.h"

namespace slalom::mrpt_io
{
namespace
{
using detail::ByteSource;

/// Decompresses the whole file once, so that a checksum error is known before the first object.
ByteSource::Damage verify(const std::filesystem::path& file, std::string& complaint)
{
  ByteSource source(file);
  if (!source.compressed()) return ByteSource::Damage::None;
  std::vector<char> scratch(1 << 18);
  while (source.read(scratch.data(), scratch.size()) > 0)
  {
  }
  complaint = source.complaint();
  return source.damage();
}

void refuseForeignFormats(const std::filesystem::path& file, const std::string& magic)
{
  const std::string name = file.string();
  if (magic.empty()) throw RawlogError(name + ": the file is empty");
  if (magic.starts_with("\x28\xb5\x2f\xfd"))
    throw RawlogError(name +
                      ": a zstd-compressed rawlog (written by MRPT 2.15 or newer); recompress it: "
                      "zstd -dc old.rawlog | gzip > new.rawlog");
  for (const std::string_view packed : {"BZh", "PK\x03\x04",
                                        "\xfd"
                                        "7zXZ",
                                        "7z\xbc\xaf", "Rar!"})
    if (magic.starts_with(packed))
      throw RawlogError(name + ": not a rawlog, but another kind of archive; unpack it first");
}

/// Old rawlogs (before MRPT 0.5.5) begin with a 32-bit length instead of a marked byte.
bool looksLikeOldHeader(std::string_view bytes)
{
  return bytes.size() > 4 && bytes[0] > 0 && bytes[0] <= 120 &&
         bytes.substr(1, 3) == std::string_view("\0\0\0", 3) && bytes[4] == 'C';
}
}  // namespace

struct RawlogReader::Impl
{
  explicit Impl(const std::filesystem::path& f) : file(f), stream(f) {}

  mrpt::serialization::CSerializable::Ptr readObject();
  void accept(const mrpt::serialization::CSerializable::Ptr& object);
  void skip(const std::string& reason);
  [[noreturn]] void fail(const std::string& what);

  std::filesystem::path file;
  detail::ObjectStream stream;
  std::string failure;  ///< sticky: every later call tells it again
  std::deque<mrpt::obs::CObservation::Ptr> queue;
  RawlogStatistics statistics;
  bool ended = false;
};

RawlogReader::RawlogReader(const std::filesystem::path& file)
{
  // The linker drops libraries of which no symbol is used, and their classes with them.
  mrpt::obs::registerAllClasses_mrpt_obs();
  mrpt::maps::registerAllClasses_mrpt_maps();
  impl_ = std::make_unique<Impl>(file);
  refuseForeignFormats(file, impl_->stream.source().magic());

  // A file that was cut is read up to the cut; next() tells.
  std::string complaint;
  const ByteSource::Damage found = verify(file, complaint);
  if (found == ByteSource::Damage::Corrupt || found == ByteSource::Damage::Io)
    throw RawlogError(file.string() + ": damaged: " + complaint + "; nothing in it can be trusted");
  if (impl_->stream.peekHeader().size == 0 && !looksLikeOldHeader(impl_->stream.peek(5)))
    throw RawlogError(file.string() + ": not a rawlog" +
                      (complaint.empty() ? "" : "; damaged: " + complaint));
  mrpt::io::setLazyLoadPathBase((file.parent_path() / (file.stem().string() + "_Images")).string());
}

RawlogReader::~RawlogReader() = default;

mrpt::obs::CObservation::Ptr RawlogReader::next()
{
  while (impl_->queue.empty())
  {
    if (!impl_->failure.empty()) throw RawlogError(impl_->failure);
    if (impl_->ended) return nullptr;
    if (impl_->stream.peek(1).empty())
    {
      const ByteSource& source = impl_->stream.source();
      if (!source.complaint().empty()) impl_->fail(source.complaint());
      impl_->ended = true;
      continue;
    }
    impl_->accept(impl_->readObject());
  }
  auto observation = impl_->queue.front();
  impl_->queue.pop_front();
  ++impl_->statistics.observations[observation->GetRuntimeClass()->className];
  return observation;
}

mrpt::serialization::CSerializable::Ptr RawlogReader::Impl::readObject()
{
  const detail::ObjectHeader header = stream.peekHeader();
  if (header.size > 0 && header.class_name != "nullptr" &&
      !mrpt::rtti::findRegisteredClass(header.class_name))
  {
    skip(header.class_name + " (unknown class)");
    stream.skipUnknownObject();
    return nullptr;
  }
  try
  {
    auto object = mrpt::serialization::archiveFrom(stream).ReadObject();
    if (!object) skip("null object");
    return object;
  }
  catch (const std::bad_alloc&)
  {
    fail("an object claims more memory than there is");
  }
  catch (const std::exception& e)
  {
    const std::string& cause = stream.source().complaint();
    fail(cause.empty() ? detail::mrptMessage(e) : cause);
  }
}

void RawlogReader::Impl::skip(const std::string& reason)
{
  ++statistics.objects;
  ++statistics.skipped[reason];
}

void RawlogReader::Impl::accept(const mrpt::serialization::CSerializable::Ptr& object)
{
  if (!object) return;
  ++statistics.objects;
  if (auto observation = std::dynamic_pointer_cast<mrpt::obs::CObservation>(object))
    queue.push_back(std::move(observation));
  else if (const auto frame = std::dynamic_pointer_cast<mrpt::obs::CSensoryFrame>(object))
    for (const auto& part : *frame)
      part ? queue.push_back(part) : void(++statistics.skipped["null object"]);
  else
    ++statistics.skipped[object->GetRuntimeClass()->className];
}

void RawlogReader::Impl::fail(const std::string& what)
{
  failure = file.string() + ": damaged: " + what + "; " + std::to_string(statistics.objects) +
            " objects before it are good";
  throw RawlogError(failure);
}

const RawlogStatistics& RawlogReader::statistics() const
{
  return impl_->statistics;
}

double RawlogReader::progress() const
{
  const ByteSource& source = impl_->stream.source();
  if (source.fileSize() == 0 || impl_->ended) return 1.0;
  return std::clamp(
      static_cast<double>(source.fileOffset()) / static_cast<double>(source.fileSize()), 0.0, 1.0);
}

}  // namespace slalom::mrpt_io
