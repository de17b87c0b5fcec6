// SPDX-License-Identifier: BSD-3-Clause
#include "Preflight.h"

#include <mrpt/obs/CObservationGPS.h>
#include <mrpt/obs/CObservationRotatingScan.h>

#include <optional>

#include "slalom/mrpt_io/RawlogReader.h"

namespace slalom::replay
{
namespace
{
using engine::StateSourceKind;

enum class Range
{
  None,
  Planar,
  Volumetric
};

Range rangeOf(const mrpt::obs::CObservation& observation, const std::string& name)
{
  if (name == "CObservation2DRangeScan") return Range::Planar;
  if (const auto* scan = dynamic_cast<const mrpt::obs::CObservationRotatingScan*>(&observation))
    return scan->rowCount > 1 ? Range::Volumetric : Range::Planar;
  return name == "CObservationVelodyneScan" || name == "CObservationPointCloud" ||
                 name == "CObservation3DRangeScan"
             ? Range::Volumetric
             : Range::None;
}

bool hasPosition(const mrpt::obs::CObservation& observation)
{
  const auto* gps = dynamic_cast<const mrpt::obs::CObservationGPS*>(&observation);
  if (!gps || !gps->has_GGA_datum()) return false;
  const auto& gga = gps->getMsgByClass<mrpt::obs::gnss::Message_NMEA_GGA>().fields;
  return gga.fix_quality > 0 && (gga.latitude_degrees != 0.0 || gga.longitude_degrees != 0.0);
}

std::string list(const std::map<std::string, std::uint64_t>& counts)
{
  std::string text;
  for (const auto& [name, count] : counts)
    text += (text.empty() ? "" : ", ") + std::to_string(count) + " " + name;
  return text;
}

void requireAFlight(const Preflight& seen, const std::filesystem::path& rawlog)
{
  const std::string file = rawlog.string();
  if (seen.observations.empty()) throw mrpt_io::RawlogError(file + ": no observation in it");
  const bool position = seen.position_fixes > 0 || seen.poses || seen.truth;
  if (seen.volumetric_range || position) return;
  if (seen.planar_range)
    throw mrpt_io::RawlogError(file + ": not a flight: a 2-D laser log (" +
                               list(seen.observations) +
                               "); a 3-D range sensor or a position source is needed");
  throw mrpt_io::RawlogError(file +
                             ": not a flight: neither a 3-D range sensor nor a position source (" +
                             list(seen.observations) + ")");
}

}  // namespace

StateSourceKind Preflight::bestSource() const
{
  // Two fixes give no heading and no velocity worth fusing.
  if (position_fixes > 2) return StateSourceKind::Fusion;
  if (poses) return StateSourceKind::PoseObservation;
  if (truth) return StateSourceKind::Truth;
  return StateSourceKind::Static;
}

Preflight inspect(const std::filesystem::path& rawlog, const std::string& truth_label,
                  double seconds)
{
  Preflight seen;
  mrpt_io::RawlogReader reader(rawlog);
  std::optional<double> first;
  try
  {
    while (const auto observation = reader.next())
    {
      const double t = mrpt::Clock::toDouble(observation->timestamp);
      if (!first) first = t;
      // A comment or a first object of another day must not end the look at once.
      if (t - *first > 10.0 * seconds || t < *first) first = t;
      if (t - *first > seconds && (seen.volumetric_range || seen.planar_range)) break;
      const std::string name = observation->GetRuntimeClass()->className;
      const std::string bare = name.substr(name.rfind(':') + 1);
      ++seen.observations[bare];
      const Range range = rangeOf(*observation, bare);
      seen.volumetric_range |= range == Range::Volumetric;
      seen.planar_range |= range == Range::Planar;
      seen.imu |= bare == "CObservationIMU";
      seen.odometry |= bare == "CObservationOdometry";
      if (bare == "CObservationRobotPose")
        (observation->sensorLabel == truth_label ? seen.truth : seen.poses) = true;
      if (hasPosition(*observation)) ++seen.position_fixes;
    }
  }
  catch (const mrpt_io::RawlogError&)
  {
    // Damage later in the file: what lies before it is still played.
    if (seen.observations.empty()) throw;
  }
  requireAFlight(seen, rawlog);
  return seen;
}

}  // namespace slalom::replay
