// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/obs/obs_frwds.h>

#include <vector>

#include "Dropped.h"
#include "slalom/core/Measurements.h"

namespace slalom::mrpt_io::detail
{
/// Accelerations and rates to ImuSample, IMU_?_VEL to a VelocityFix in world axes.
void decodeImu(const mrpt::obs::CObservationIMU& imu, double t, double velocity_sigma,
               std::vector<core::Measurement>& out, Dropped& dropped);

/// The planar twist to a VelocityFix in body axes, z not measured; the planar pose if asked for.
void decodeOdometry(const mrpt::obs::CObservationOdometry& odometry, double t,
                    double velocity_sigma, bool use_pose, std::vector<core::Measurement>& out,
                    Dropped& dropped);

/// A covariance of zero or identity means that nobody set it; then PoseFix keeps its defaults.
[[nodiscard]] core::PoseFix decodePose(const mrpt::obs::CObservationRobotPose& observation,
                                       double t);

}  // namespace slalom::mrpt_io::detail
