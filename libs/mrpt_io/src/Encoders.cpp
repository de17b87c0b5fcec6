// SPDX-License-Identifier: BSD-3-Clause
#include "slalom/mrpt_io/Encoders.h"

#include <mrpt/obs/CObservationGPS.h>
#include <mrpt/obs/CObservationIMU.h>
#include <mrpt/obs/CObservationRobotPose.h>
#include <mrpt/obs/CObservationVelodyneScan.h>

#include <chrono>
#include <cmath>
#include <cstring>
#include <numbers>

#include "MrptConvert.h"

namespace slalom::mrpt_io
{
namespace
{
constexpr double kKnot = 1852.0 / 3600.0;  // [m/s]

template <class Observation>
std::shared_ptr<Observation> make(double stamp, const std::string& label)
{
  auto observation = std::make_shared<Observation>();
  observation->timestamp = mrpt::Clock::fromDouble(stamp);
  observation->sensorLabel = label;
  return observation;
}

struct Calendar
{
  std::chrono::year_month_day date;
  int hour, minute;
  double second;
};

Calendar calendar(double stamp)
{
  using namespace std::chrono;
  const auto day = sys_days(days(static_cast<int>(std::floor(stamp / 86400.0))));
  const double in_day = stamp - 86400.0 * static_cast<double>(day.time_since_epoch().count());
  const int minutes = static_cast<int>(in_day / 60.0);
  return {year_month_day(day), minutes / 60, minutes % 60, in_day - 60.0 * minutes};
}

mrpt::obs::gnss::UTC_time utc(const Calendar& c)
{
  mrpt::obs::gnss::UTC_time time;
  time.hour = static_cast<std::uint8_t>(c.hour);
  time.minute = static_cast<std::uint8_t>(c.minute);
  time.sec = c.second;
  return time;
}

mrpt::obs::gnss::Message_NMEA_GGA gga(const Calendar& c, const GpsReading& reading,
                                      const Eigen::Vector3d& geodetic)
{
  mrpt::obs::gnss::Message_NMEA_GGA message;
  auto& f = message.fields;
  const int quality = static_cast<int>(reading.fix);
  f.UTCTime = utc(c);
  f.latitude_degrees = geodetic.x();
  f.longitude_degrees = geodetic.y();
  f.altitude_meters = geodetic.z();
  f.orthometric_altitude = geodetic.z();
  f.corrected_orthometric_altitude = geodetic.z();
  f.fix_quality = static_cast<std::uint8_t>(quality);
  f.satellitesUsed = 12;
  f.thereis_HDOP = true;
  f.HDOP = static_cast<float>(reading.sigma / gpsSigmaPerHdop(quality));
  return message;
}

mrpt::obs::gnss::Message_NMEA_RMC rmc(const Calendar& c, const GpsReading& reading,
                                      const Eigen::Vector3d& geodetic)
{
  mrpt::obs::gnss::Message_NMEA_RMC message;
  auto& f = message.fields;
  const double course =
      std::atan2(reading.v_W.x(), reading.v_W.y()) * 180.0 / std::numbers::pi;  // from north
  f.UTCTime = utc(c);
  f.validity_char = 'A';
  f.positioning_mode = 'A';
  f.latitude_degrees = geodetic.x();
  f.longitude_degrees = geodetic.y();
  f.speed_knots = std::hypot(reading.v_W.x(), reading.v_W.y()) / kKnot;
  f.direction_degrees = course < 0.0 ? course + 360.0 : course;
  f.date_day = static_cast<std::uint8_t>(static_cast<unsigned>(c.date.day()));
  f.date_month = static_cast<std::uint8_t>(static_cast<unsigned>(c.date.month()));
  f.date_year = static_cast<std::uint8_t>(static_cast<int>(c.date.year()) % 100);
  return message;
}
}  // namespace

ObservationPtr makeImuObservation(double stamp, const core::ImuSample& sample,
                                  const std::string& label, const Eigen::Isometry3d& T_BS)
{
  auto imu = make<mrpt::obs::CObservationIMU>(stamp, label);
  const Eigen::Vector3d f_S = T_BS.linear().transpose() * sample.f_B;
  const Eigen::Vector3d w_S = T_BS.linear().transpose() * sample.w_B;
  imu->sensorPose = detail::toMrpt(T_BS);
  imu->set(mrpt::obs::IMU_X_ACC, f_S.x());
  imu->set(mrpt::obs::IMU_Y_ACC, f_S.y());
  imu->set(mrpt::obs::IMU_Z_ACC, f_S.z());
  imu->set(mrpt::obs::IMU_WX, w_S.x());
  imu->set(mrpt::obs::IMU_WY, w_S.y());
  imu->set(mrpt::obs::IMU_WZ, w_S.z());
  return imu;
}

ObservationPtr makeVelocityObservation(double stamp, const Eigen::Vector3d& v_W,
                                       const std::string& label)
{
  auto imu = make<mrpt::obs::CObservationIMU>(stamp, label);
  imu->set(mrpt::obs::IMU_X_VEL, v_W.x());
  imu->set(mrpt::obs::IMU_Y_VEL, v_W.y());
  imu->set(mrpt::obs::IMU_Z_VEL, v_W.z());
  return imu;
}

ObservationPtr makeGpsObservation(double stamp, const GpsReading& reading, const EnuFrame& frame,
                                  const std::string& label)
{
  auto gps = make<mrpt::obs::CObservationGPS>(stamp, label);
  const Eigen::Vector3d geodetic = frame.toGeodetic(reading.p_W);
  const Calendar time = calendar(stamp);
  gps->sensorPose.setFromValues(reading.lever_B.x(), reading.lever_B.y(), reading.lever_B.z());
  gps->has_satellite_timestamp = true;
  gps->originalReceivedTimestamp = gps->timestamp;
  gps->setMsg(gga(time, reading, geodetic));
  gps->setMsg(rmc(time, reading, geodetic));
  return gps;
}

ObservationPtr makePoseObservation(double stamp, const core::PoseFix& pose,
                                   const std::string& label)
{
  auto observation = make<mrpt::obs::CObservationRobotPose>(stamp, label);
  observation->pose.mean = detail::toMrpt(pose.T_WB);
  for (int i = 0; i < 6; ++i)
  {
    const double sigma = i < 3 ? pose.sigma_position : pose.sigma_rotation;
    observation->pose.cov(i, i) = sigma * sigma;
  }
  return observation;
}

ObservationPtr makeVelodyneObservation(double stamp, std::span<const VelodynePacket> packets,
                                       const Eigen::Isometry3d& T_BS, const std::string& label)
{
  auto scan = make<mrpt::obs::CObservationVelodyneScan>(stamp, label);
  scan->sensorPose = detail::toMrpt(T_BS);
  // The default of 1 m would make other readers drop what is near.
  scan->minRange = 0.1;
  scan->maxRange = 130.0;
  scan->originalReceivedTimestamp = scan->timestamp;
  scan->scan_packets.resize(packets.size());
  static_assert(sizeof(VelodynePacket) == sizeof(scan->scan_packets[0]));
  if (!packets.empty())
    std::memcpy(static_cast<void*>(scan->scan_packets.data()), packets.data(),
                packets.size_bytes());
  const bool hdl32 = !packets.empty() && packets.front().model == VelodynePacket::kHdl32;
  scan->calibration =
      mrpt::obs::VelodyneCalibration::LoadDefaultCalibration(hdl32 ? "HDL32" : "VLP16");
  return scan;
}

}  // namespace slalom::mrpt_io
