// SPDX-License-Identifier: BSD-3-Clause
#include "GpsDecoder.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "FieldText.h"
#include "slalom/mrpt_io/Encoders.h"
#include "slalom/mrpt_io/IniDocument.h"

namespace slalom::mrpt_io
{
double gpsSigmaPerHdop(int fix_quality)
{
  switch (fix_quality)
  {
    case 2:  // differential
      return 0.8;
    case 4:  // real-time kinematic, fixed
      return 0.02;
    case 5:  // real-time kinematic, float
      return 0.3;
    case 6:  // dead reckoning of the receiver
      return 5.0;
    default:  // single, PPS, manual, simulation
      return 1.5;
  }
}

namespace detail
{
namespace
{
using mrpt::obs::gnss::Message_NMEA_GGA;
using mrpt::obs::gnss::Message_NMEA_RMC;

constexpr double kKnot = 1852.0 / 3600.0;         // [m/s]
constexpr double kVerticalRatio = 1.5;            // vertical over horizontal standard deviation
constexpr double kDefaultHdop = 1.5;              // of receivers that tell none
constexpr double kSpeedSigmaPerHdop = 0.1;        // [m/s] Doppler
constexpr double kHighest = 2e4, kLowest = -1e3;  // [m]

/// The const overload of MRPT 2.5.8's getMsgByClassPtr() does not compile.
template <class Message>
const Message* messageOf(const mrpt::obs::CObservationGPS& gps)
{
  const auto type = static_cast<mrpt::obs::gnss::gnss_message_type_t>(Message::msg_type);
  const auto found = gps.messages.find(type);
  if (found == gps.messages.end()) return nullptr;
  return dynamic_cast<const Message*>(found->second.get());
}

double hdopOf(const Message_NMEA_GGA& gga)
{
  const auto hdop = static_cast<double>(gga.fields.HDOP);
  const bool told = gga.fields.thereis_HDOP && std::isfinite(hdop) && hdop > 0.0;
  return told ? std::clamp(hdop, 0.05, 50.0) : kDefaultHdop;
}

/// "" when the fix can be used.
std::string refusal(const Message_NMEA_GGA& gga)
{
  const double lat = gga.fields.latitude_degrees, lon = gga.fields.longitude_degrees;
  const double height = gga.fields.altitude_meters;
  if (gga.fields.fix_quality == 0) return "GPS without fix";
  if (!std::isfinite(lat) || !std::isfinite(lon) || !std::isfinite(height)) return "GPS not finite";
  if (lat == 0.0 && lon == 0.0) return "GPS at 0,0";
  if (std::abs(lat) > 90.0 || std::abs(lon) > 360.0 || height > kHighest || height < kLowest)
    return "GPS outside the earth's surface";
  return "";
}

std::optional<core::VelocityFix> horizontalVelocity(const Message_NMEA_RMC& rmc, double sigma)
{
  const double speed = rmc.fields.speed_knots * kKnot;
  const double course = rmc.fields.direction_degrees * std::numbers::pi / 180.0;
  if (rmc.fields.validity_char != 'A' || !std::isfinite(speed) || !std::isfinite(course))
    return std::nullopt;
  core::VelocityFix fix;
  fix.v = {speed * std::sin(course), speed * std::cos(course), 0.0};
  fix.sigma = {sigma, sigma, std::numeric_limits<double>::infinity()};
  return fix;
}
}  // namespace

GpsDecoder::GpsDecoder(const InputConfig& config) : velocity_sigma_(config.velocity_sigma_mps)
{
  if (config.datum.empty()) return;
  const auto datum = toVector(config.datum);
  if (!datum || std::abs(datum->x()) > 90.0 || std::abs(datum->y()) > 360.0)
    throw ConfigError("[input] datum = " + config.datum +
                      ": must be lat_deg,lon_deg,alt_m with |lat| <= 90, |lon| <= 360");
  frame_.emplace(*datum);
}

void GpsDecoder::decode(const mrpt::obs::CObservationGPS& gps, double t,
                        std::vector<core::Measurement>& out, Dropped& dropped)
{
  const auto* gga = messageOf<Message_NMEA_GGA>(gps);
  if (!gga)
  {
    ++dropped["GPS without GGA"];
    return;
  }
  if (const std::string reason = refusal(*gga); !reason.empty())
  {
    ++dropped[reason];
    return;
  }
  // MRPT packs its messages: values must be copied before anything takes a reference to them.
  const double latitude = gga->fields.latitude_degrees, longitude = gga->fields.longitude_degrees;
  const double height = gga->fields.altitude_meters;
  const Eigen::Vector3d geodetic(latitude, longitude, height);
  if (!frame_) frame_.emplace(geodetic);
  const double hdop = hdopOf(*gga);
  core::PositionFix fix;
  fix.t = t;
  fix.p_W = frame_->toEnu(geodetic);
  fix.sigma =
      gpsSigmaPerHdop(gga->fields.fix_quality) * hdop * Eigen::Vector3d(1.0, 1.0, kVerticalRatio);
  fix.lever_B = {gps.sensorPose.x(), gps.sensorPose.y(), gps.sensorPose.z()};
  fix.source = gps.sensorLabel;
  out.emplace_back(fix);

  const auto* rmc = messageOf<Message_NMEA_RMC>(gps);
  if (!rmc) return;
  if (auto velocity =
          horizontalVelocity(*rmc, std::max(velocity_sigma_, kSpeedSigmaPerHdop * hdop)))
  {
    velocity->t = t;
    velocity->source = gps.sensorLabel;
    out.emplace_back(*velocity);
  }
}

}  // namespace detail
}  // namespace slalom::mrpt_io
