// SPDX-License-Identifier: BSD-3-Clause
#include "Nmea.h"

#include <charconv>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "FieldText.h"

namespace slalom::mrpt_io::detail
{
namespace
{
using mrpt::obs::gnss::Message_NMEA_GGA;
using mrpt::obs::gnss::Message_NMEA_RMC;

/// The text between '$' and '*', or nothing when the checksum behind it is wrong.
std::string_view checkedBody(std::string_view sentence)
{
  const std::size_t star = sentence.find('*');
  if (!sentence.starts_with('$') || star == std::string_view::npos || sentence.size() < star + 3)
    return {};
  const std::string_view body = sentence.substr(1, star - 1);
  unsigned sum = 0, told = 0;
  for (const char c : body) sum ^= static_cast<unsigned char>(c);
  const char* digits = sentence.data() + star + 1;
  const auto [end, error] = std::from_chars(digits, digits + 2, told, 16);
  return error == std::errc() && end == digits + 2 && sum == told ? body : std::string_view();
}

std::vector<std::string_view> split(std::string_view body)
{
  std::vector<std::string_view> fields;
  for (std::size_t comma = 0; comma != std::string_view::npos;)
  {
    comma = body.find(',');
    fields.push_back(body.substr(0, comma));
    body.remove_prefix(comma == std::string_view::npos ? body.size() : comma + 1);
  }
  return fields;
}

/// ddmm.mmmm or dddmm.mmmm with its hemisphere to signed degrees.
std::optional<double> angle(std::string_view text, std::string_view hemisphere)
{
  const auto value = toNumber(text);
  if (!value || *value < 0.0 || hemisphere.size() != 1) return std::nullopt;
  const double degrees = std::floor(*value / 100.0);
  const double minutes = *value - 100.0 * degrees;
  if (minutes >= 60.0) return std::nullopt;
  const double angle = degrees + minutes / 60.0;
  return hemisphere == "S" || hemisphere == "W" ? -angle : angle;
}

std::optional<mrpt::obs::gnss::UTC_time> utc(std::string_view text)
{
  const auto value = toNumber(text);
  if (!value || *value < 0.0 || *value >= 240000.0) return std::nullopt;
  const int whole = static_cast<int>(*value);
  mrpt::obs::gnss::UTC_time time;
  time.hour = static_cast<std::uint8_t>(whole / 10000);
  time.minute = static_cast<std::uint8_t>(whole / 100 % 100);
  time.sec = whole % 100 + (*value - whole);
  return time;
}

bool readRmc(const std::vector<std::string_view>& f, mrpt::obs::CObservationGPS& gps)
{
  if (f.size() < 10 || f[2].size() != 1) return false;
  const auto time = utc(f[1]);
  const auto date = toInteger(f[9]);
  const auto latitude = angle(f[3], f[4]), longitude = angle(f[5], f[6]);
  if (!time || !date || !latitude || !longitude) return false;
  Message_NMEA_RMC message;
  message.fields.UTCTime = *time;
  message.fields.validity_char = static_cast<std::int8_t>(f[2][0]);
  message.fields.latitude_degrees = *latitude;
  message.fields.longitude_degrees = *longitude;
  // Receivers leave speed and course empty at rest.
  message.fields.speed_knots = toNumber(f[7]).value_or(0.0);
  message.fields.direction_degrees = toNumber(f[8]).value_or(0.0);
  message.fields.date_day = static_cast<std::uint8_t>(*date / 10000);
  message.fields.date_month = static_cast<std::uint8_t>(*date / 100 % 100);
  message.fields.date_year = static_cast<std::uint8_t>(*date % 100);
  if (f.size() > 12 && f[12].size() == 1) message.fields.positioning_mode = f[12][0];
  gps.setMsg(message);
  return true;
}

bool readGga(const std::vector<std::string_view>& f, mrpt::obs::CObservationGPS& gps)
{
  if (f.size() < 12) return false;
  const auto time = utc(f[1]);
  const auto latitude = angle(f[2], f[3]), longitude = angle(f[4], f[5]);
  const auto quality = toInteger(f[6]);
  const auto altitude = toNumber(f[9]);
  if (!time || !latitude || !longitude || !quality || !altitude) return false;
  Message_NMEA_GGA message;
  const auto hdop = toNumber(f[8]);
  message.fields.UTCTime = *time;
  message.fields.latitude_degrees = *latitude;
  message.fields.longitude_degrees = *longitude;
  message.fields.fix_quality = static_cast<std::uint8_t>(*quality);
  message.fields.satellitesUsed = static_cast<std::uint32_t>(toInteger(f[7]).value_or(0));
  message.fields.thereis_HDOP = hdop.has_value();
  message.fields.HDOP = static_cast<float>(hdop.value_or(0.0));
  message.fields.altitude_meters = *altitude;
  message.fields.geoidal_distance = toNumber(f[11]).value_or(0.0);
  message.fields.orthometric_altitude = *altitude + message.fields.geoidal_distance;
  message.fields.corrected_orthometric_altitude = message.fields.orthometric_altitude;
  gps.setMsg(message);
  return true;
}
}  // namespace

bool readNmea(std::string_view sentence, mrpt::obs::CObservationGPS& gps)
{
  const std::vector<std::string_view> fields = split(checkedBody(sentence));
  if (fields[0].size() != 5) return false;
  const std::string_view kind = fields[0].substr(2);
  if (kind == "RMC") return readRmc(fields, gps);
  if (kind == "GGA") return readGga(fields, gps);
  return false;
}

}  // namespace slalom::mrpt_io::detail
