// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/obs/CObservationGPS.h>

#include <string_view>

namespace slalom::mrpt_io::detail
{
/** Reads one NMEA 0183 sentence into a GPS observation. Understands RMC and GGA of any talker.
 *  @return false, and `gps` unchanged, for other sentences, a wrong checksum or malformed fields */
bool readNmea(std::string_view sentence, mrpt::obs::CObservationGPS& gps);

}  // namespace slalom::mrpt_io::detail
