// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/io/CMemoryStream.h>
#include <mrpt/obs/CObservation.h>
#include <mrpt/serialization/CArchive.h>
#include <zlib.h>

#include <filesystem>
#include <string>
#include <vector>

#include "Files.h"
#include "slalom/mrpt_io/RawlogReader.h"

namespace slalom::test
{
/// The bytes of one object as they stand in an uncompressed rawlog; nullptr gives a null object.
[[nodiscard]] inline std::string serialized(const mrpt::serialization::CSerializable* object)
{
  mrpt::io::CMemoryStream memory;
  mrpt::serialization::archiveFrom(memory).WriteObject(object);
  return {static_cast<const char*>(memory.getRawBufferData()),
          static_cast<std::size_t>(memory.getTotalBytesCount())};
}

[[nodiscard]] inline std::string gzipped(const std::string& bytes)
{
  z_stream z{};
  deflateInit2(&z, 6, Z_DEFLATED, 16 + MAX_WBITS, 8, Z_DEFAULT_STRATEGY);
  std::string out(deflateBound(&z, bytes.size()) + 64, '\0');
  z.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
  z.avail_in = static_cast<unsigned>(bytes.size());
  z.next_out = reinterpret_cast<Bytef*>(out.data());
  z.avail_out = static_cast<unsigned>(out.size());
  deflate(&z, Z_FINISH);
  out.resize(z.total_out);
  deflateEnd(&z);
  return out;
}

/// What came out of a rawlog, object by object, and how it ended.
struct Reading
{
  std::vector<std::string> objects;  ///< serialized again
  std::string error;                 ///< "" = regular end
  bool refused = false;              ///< the constructor threw
  mrpt_io::RawlogStatistics statistics;
};

[[nodiscard]] inline Reading readAll(const std::filesystem::path& file)
{
  Reading result;
  result.refused = true;
  try
  {
    mrpt_io::RawlogReader reader(file);
    result.refused = false;
    try
    {
      while (const auto observation = reader.next())
        result.objects.push_back(serialized(observation.get()));
    }
    catch (const mrpt_io::RawlogError& e)
    {
      result.error = e.what();
    }
    result.statistics = reader.statistics();
  }
  catch (const mrpt_io::RawlogError& e)
  {
    result.error = e.what();
  }
  return result;
}

}  // namespace slalom::test
