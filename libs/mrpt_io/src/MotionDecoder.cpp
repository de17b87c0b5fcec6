// SPDX-License-Identifier: BSD-3-Clause
#include "MotionDecoder.h"

#include <mrpt/obs/CObservationIMU.h>
#include <mrpt/obs/CObservationOdometry.h>
#include <mrpt/obs/CObservationRobotPose.h>

#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "MrptConvert.h"

namespace slalom::mrpt_io::detail
{
namespace
{
using mrpt::obs::CObservationIMU;
using mrpt::obs::TIMUDataIndex;

std::optional<Eigen::Vector3d> triple(const CObservationIMU& imu, TIMUDataIndex x, TIMUDataIndex y,
                                      TIMUDataIndex z)
{
  if (!imu.has(x) || !imu.has(y) || !imu.has(z)) return std::nullopt;
  return Eigen::Vector3d(imu.get(x), imu.get(y), imu.get(z));
}

/// Standard deviation from three diagonal terms, or `fallback` when nobody set them.
double sigmaOf(const mrpt::math::CMatrixDouble66& covariance, int first, double fallback)
{
  const double variance = (covariance(first, first) + covariance(first + 1, first + 1) +
                           covariance(first + 2, first + 2)) /
                          3.0;
  const bool unset = !(variance > 0.0) || !std::isfinite(variance) || variance == 1.0;
  return unset ? fallback : std::sqrt(variance);
}
}  // namespace

void decodeImu(const CObservationIMU& imu, double t, double velocity_sigma,
               std::vector<core::Measurement>& out, Dropped& dropped)
{
  using namespace mrpt::obs;
  const auto f_S = triple(imu, IMU_X_ACC, IMU_Y_ACC, IMU_Z_ACC);
  const auto w_S = triple(imu, IMU_WX, IMU_WY, IMU_WZ);
  const auto v_W = triple(imu, IMU_X_VEL, IMU_Y_VEL, IMU_Z_VEL);
  if (!(f_S && w_S) && !v_W) ++dropped["IMU without acceleration and rate"];
  if ((f_S && w_S && !(f_S->allFinite() && w_S->allFinite())) || (v_W && !v_W->allFinite()))
  {
    ++dropped["IMU not finite"];
    return;
  }
  if (f_S && w_S)
  {
    const Eigen::Matrix3d R_BS = toEigen(imu.sensorPose).linear();
    out.emplace_back(core::ImuSample{t, R_BS * *f_S, R_BS * *w_S});
  }
  if (v_W)
    out.emplace_back(core::VelocityFix{t, *v_W, Eigen::Vector3d::Constant(velocity_sigma), false,
                                       imu.sensorLabel});
}

void decodeOdometry(const mrpt::obs::CObservationOdometry& odometry, double t,
                    double velocity_sigma, bool use_pose, std::vector<core::Measurement>& out,
                    Dropped& dropped)
{
  const auto& twist = odometry.velocityLocal;
  const Eigen::Vector3d pose(odometry.odometry.x(), odometry.odometry.y(), odometry.odometry.phi());
  if ((odometry.hasVelocities && !(std::isfinite(twist.vx) && std::isfinite(twist.vy))) ||
      (use_pose && !pose.allFinite()))
  {
    ++dropped["odometry not finite"];
    return;
  }
  if (odometry.hasVelocities)
  {
    core::VelocityFix fix;
    fix.t = t;
    fix.v = {twist.vx, twist.vy, 0.0};
    fix.sigma = {velocity_sigma, velocity_sigma, std::numeric_limits<double>::infinity()};
    fix.in_body = true;
    fix.source = odometry.sensorLabel;
    out.emplace_back(fix);
  }
  if (use_pose)
  {
    core::PoseFix fix;
    fix.t = t;
    fix.T_WB.linear() = Eigen::AngleAxisd(pose.z(), Eigen::Vector3d::UnitZ()).toRotationMatrix();
    fix.T_WB.translation() = Eigen::Vector3d(pose.x(), pose.y(), 0.0);
    fix.source = odometry.sensorLabel;
    out.emplace_back(fix);
  }
  if (!odometry.hasVelocities && !use_pose) ++dropped["odometry without velocity"];
}

core::PoseFix decodePose(const mrpt::obs::CObservationRobotPose& observation, double t)
{
  core::PoseFix fix;
  fix.t = t;
  // `pose` is the vehicle's; sensorPose tells where the tracker's marker sits and is already
  // undone.
  fix.T_WB = toEigen(observation.pose.mean);
  fix.sigma_position = sigmaOf(observation.pose.cov, 0, fix.sigma_position);
  fix.sigma_rotation = sigmaOf(observation.pose.cov, 3, fix.sigma_rotation);
  fix.source = observation.sensorLabel;
  return fix;
}

}  // namespace slalom::mrpt_io::detail
