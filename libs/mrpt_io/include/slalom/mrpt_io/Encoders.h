// SPDX-License-Identifier: BSD-3-Clause
/** Measurements to MRPT observations: what a recorder writes, ObservationDecoder reads back
 * (tests/unit/mrpt_io/test_round_trip.cpp). All stamps are Unix times [s]. */
#pragma once

#include <mrpt/obs/CObservation.h>
#include <mrpt/obs/obs_frwds.h>

#include <Eigen/Geometry>
#include <memory>
#include <span>
#include <string>

#include "slalom/core/Measurements.h"
#include "slalom/mrpt_io/Geodesy.h"
#include "slalom/mrpt_io/Velodyne.h"

namespace slalom::mrpt_io
{
using ObservationPtr = mrpt::obs::CObservation::Ptr;

/// Accelerations and rates (MRPT indices IMU_?_ACC, IMU_W?) in the axes of the IMU.
/// @param T_BS mount of the IMU; `sample` is in body axes
[[nodiscard]] ObservationPtr makeImuObservation(
    double stamp, const core::ImuSample& sample, const std::string& label = "IMU",
    const Eigen::Isometry3d& T_BS = Eigen::Isometry3d::Identity());

/** Velocity in world axes as a CObservationIMU that carries IMU_X_VEL, IMU_Y_VEL, IMU_Z_VEL and
 * nothing else. MRPT 2.5.8 has no other standard observation for a 3-D velocity: the twist of
 * CObservationOdometry is planar. `rawlog-edit --export-imu-txt` shows it. */
[[nodiscard]] ObservationPtr makeVelocityObservation(double stamp, const Eigen::Vector3d& v_W,
                                                     const std::string& label = "VELOCITY");

/// Kinds of fix as in NMEA GGA.
enum class GpsFix
{
  Single = 1,
  Differential = 2,
  RtkFixed = 4,
  RtkFloat = 5
};

/// What a GPS receiver says at one instant.
struct GpsReading
{
  Eigen::Vector3d p_W = Eigen::Vector3d::Zero();  ///< [m] antenna
  Eigen::Vector3d v_W = Eigen::Vector3d::Zero();  ///< [m/s]; its horizontal part goes into RMC
  double sigma = 1.0;  ///< [m] horizontal standard deviation per axis, carried as HDOP
  GpsFix fix = GpsFix::Single;
  Eigen::Vector3d lever_B = Eigen::Vector3d::Zero();  ///< [m] antenna on the vehicle
};

/// GGA and RMC. The height of `frame`'s datum counts as height above sea level.
[[nodiscard]] ObservationPtr makeGpsObservation(double stamp, const GpsReading& reading,
                                                const EnuFrame& frame,
                                                const std::string& label = "GPS");

/// CObservationRobotPose with an isotropic covariance; label "GROUND_TRUTH" is truth by default.
[[nodiscard]] ObservationPtr makePoseObservation(double stamp, const core::PoseFix& pose,
                                                 const std::string& label);

/// A revolution (or any run) of raw packets; `stamp` is the first firing of the first packet.
[[nodiscard]] ObservationPtr makeVelodyneObservation(double stamp,
                                                     std::span<const VelodynePacket> packets,
                                                     const Eigen::Isometry3d& T_BS,
                                                     const std::string& label = "VELODYNE");

/// Standard deviation per unit of HDOP that the decoder assumes for a kind of GGA fix [m].
[[nodiscard]] double gpsSigmaPerHdop(int fix_quality);

}  // namespace slalom::mrpt_io
