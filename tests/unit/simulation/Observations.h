// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/obs/CObservationVelodyneScan.h>

#include <sstream>
#include <string>

namespace slalom::test
{
/// What an observation says: the packets of a scan, the text of everything else.
inline std::string bytesOf(const mrpt::obs::CObservation& observation)
{
  const auto* scan = dynamic_cast<const mrpt::obs::CObservationVelodyneScan*>(&observation);
  if (scan)
    return {reinterpret_cast<const char*>(scan->scan_packets.data()),
            scan->scan_packets.size() * sizeof(scan->scan_packets[0])};
  std::ostringstream text;
  observation.getDescriptionAsText(text);
  return text.str();
}
}  // namespace slalom::test
