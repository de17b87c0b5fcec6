// SPDX-License-Identifier: BSD-3-Clause
#include "Prediction.h"

#include <algorithm>
#include <cmath>

#include "slalom/core/Math.h"

namespace slalom::estimation::detail
{
namespace
{
using Eigen::Matrix3d;
using Eigen::Vector3d;
using Columns = Eigen::Matrix<double, 15, 3>;

// Beyond these a MEMS sensor clips or its mount rings: the integrated signal is not to be trusted.
constexpr double kShockForce = 80.0;      // [m/s^2]
constexpr double kShockRate = 30.0;       // [rad/s]
constexpr double kVibrationMemory = 0.5;  // [s]
// Measured noise counts only when it is far above the configured one, so that a well configured
// sensor keeps exactly its configured density.
constexpr double kVibrationRatio2 = 4.0;
// Turns make differences too, and a gyroscope's own filter leaves less alias than an
// accelerometer's (recorded flights fit best with about this share).
constexpr double kGyroVibrationShare = 0.1;

constexpr double kSmoothing = 0.3;        // [s] of the acceleration
constexpr double kManoeuvreMemory = 2.0;  // [s] of its power
constexpr double kLevelTime = 0.5;        // [s] relaxation of an unobserved tilt
constexpr double kTiltLimit = 0.25;       // [rad] what a multi-rotor's unobserved tilt may be
constexpr double kYawLimit = 1.8;         // [rad] uniform heading: pi / sqrt(3)
constexpr double kPoseMemory = 1.0;       // [s]

double density2(double configured, double measured2)
{
  const double configured2 = configured * configured;
  return measured2 > kVibrationRatio2 * configured2 ? measured2 : configured2;
}

// P <- Phi P Phi^T, exploiting the zero and identity blocks of Phi:
//   [p]' = [p] + dt/2 ([v] + [v]')   [v]' = [v] - dt f x [theta] - dt R [ba] + dt^2/2 f x R [bg]
//   [theta]' = [theta] - dt R [bg]
// P is symmetric: P Phi^T, a transposition and once more the same.
void transport(Matrix15& P, const Matrix3d& R, const Vector3d& f_W, double dt)
{
  const Matrix3d v_theta = -dt * core::skew(f_W);
  const Matrix3d theta_g = -dt * R;
  const Matrix3d v_g_T = (0.5 * v_theta * theta_g).transpose();
  const Matrix3d v_theta_T = v_theta.transpose();
  const Matrix3d theta_g_T = theta_g.transpose();
  const auto timesPhiT = [&]()
  {
    const Columns old_v = P.middleCols<3>(kV);
    P.middleCols<3>(kV).noalias() += P.middleCols<3>(kR) * v_theta_T;
    P.middleCols<3>(kV).noalias() += P.middleCols<3>(kBa) * theta_g_T;
    P.middleCols<3>(kV).noalias() += P.middleCols<3>(kBg) * v_g_T;
    P.middleCols<3>(kR).noalias() += P.middleCols<3>(kBg) * theta_g_T;
    P.middleCols<3>(kP) += 0.5 * dt * (old_v + P.middleCols<3>(kV));
  };
  timesPhiT();
  P.transposeInPlace();
  timesPhiT();
}

void addVelocityNoise(Matrix15& P, double power, double dt)
{
  for (int i = 0; i < 3; ++i)
  {
    P(kV + i, kV + i) += power * dt;
    P(kP + i, kV + i) += 0.5 * power * dt * dt;
    P(kV + i, kP + i) += 0.5 * power * dt * dt;
    P(kP + i, kP + i) += power * dt * dt * dt / 3.0;
  }
}

void symmetrise(Matrix15& P)
{
  P = 0.5 * (P + P.transpose()).eval();
}

// Scales row and column i so that the variance stays below limit^2; a congruence, so P stays
// positive.
void limitVariance(Matrix15& P, int i, double limit)
{
  if (P(i, i) <= limit * limit) return;
  const double scale = limit / std::sqrt(P(i, i));
  P.row(i) *= scale;
  P.col(i) *= scale;
}

Eigen::Quaterniond relaxedToLevel(const Eigen::Quaterniond& q, double dt)
{
  const Eigen::Quaterniond level = core::fromYaw(core::yawOf(q));
  return q.slerp(1.0 - std::exp(-dt / kLevelTime), level).normalized();
}
}  // namespace

RatedImu ImuRater::rate(const core::ImuSample& sample)
{
  const double dt = std::clamp(sample.t - last_.t, 1e-4, 0.1);
  if (primed_)
  {
    const double fade = 1.0 - std::exp(-dt / kVibrationMemory);
    const double accel2 = (sample.f_B - last_.f_B).squaredNorm() / 6.0 * dt;
    const double gyro2 = kGyroVibrationShare * (sample.w_B - last_.w_B).squaredNorm() / 6.0 * dt;
    accel_power_ += fade * (accel2 - accel_power_);
    gyro_power_ += fade * (gyro2 - gyro_power_);
  }
  primed_ = true;
  last_ = sample;

  RatedImu rated{sample, density2(config_.accel_noise, accel_power_),
                 density2(config_.gyro_noise, gyro_power_)};
  // An error as large as the signal itself, for one sampling interval.
  if (sample.f_B.norm() > kShockForce) rated.accel_density2 += sample.f_B.squaredNorm() * dt;
  if (sample.w_B.norm() > kShockRate) rated.gyro_density2 += sample.w_B.squaredNorm() * dt;
  return rated;
}

double pretendedManoeuvre2(const FilterState& s, double accel_density2)
{
  const double noise2 = accel_density2 / kSmoothing;  // two axes of density / (2 smoothing)
  const double tilt2 = s.P(kR, kR) + s.P(kR + 1, kR + 1);
  return 1.5 * (noise2 + kGravity * kGravity * tilt2);
}

void predictInertial(FilterState& s, double t, const RatedImu& before, const RatedImu& after,
                     const FilterConfig& config)
{
  const double dt = t - s.t;
  s.w_B = 0.5 * (before.sample.w_B + after.sample.w_B) - s.bg;
  const Vector3d f_B = 0.5 * (before.sample.f_B + after.sample.f_B) - s.ba;

  // Attitude at mid-interval carries the force.
  const Matrix3d R = (s.q * core::expSO3(0.5 * dt * s.w_B)).toRotationMatrix();
  const Vector3d f_W = R * f_B;
  const Vector3d a_W = f_W - kGravity * Vector3d::UnitZ();
  s.p += dt * s.v + 0.5 * dt * dt * a_W;
  s.v += dt * a_W;
  s.q = (s.q * core::expSO3(dt * s.w_B)).normalized();

  const double accel_density2 = std::max(before.accel_density2, after.accel_density2);
  s.a_W += (1.0 - std::exp(-dt / kSmoothing)) * (a_W - s.a_W);
  s.manoeuvre2 +=
      (1.0 - std::exp(-dt / kManoeuvreMemory)) * (s.a_W.head<2>().squaredNorm() - s.manoeuvre2);
  const double pretended = pretendedManoeuvre2(s, accel_density2);
  const double significance = s.manoeuvre2 > pretended ? 1.0 - pretended / s.manoeuvre2 : 0.0;

  // A rotation error turns the specific force, not the acceleration.
  transport(s.P, R, {significance * f_W.x(), significance * f_W.y(), f_W.z()}, dt);
  addVelocityNoise(s.P, accel_density2, dt);
  s.P.diagonal().segment<3>(kR).array() += std::max(before.gyro_density2, after.gyro_density2) * dt;
  s.P.diagonal().segment<3>(kBg).array() += config.gyro_bias_walk * config.gyro_bias_walk * dt;
  s.P.diagonal().segment<3>(kBa).array() += config.accel_bias_walk * config.accel_bias_walk * dt;
  symmetrise(s.P);
  s.t = t;
  s.last_imu = t;
}

void predictKinematic(FilterState& s, double t, const FilterConfig& config)
{
  const double dt = t - s.t;
  s.p += dt * s.v;
  s.w_B.setZero();
  s.a_W.setZero();
  s.manoeuvre2 = 0.0;
  if (s.t - s.last_rotation > kPoseMemory) s.q = relaxedToLevel(s.q, dt);

  s.P.middleRows<3>(kP) += dt * s.P.middleRows<3>(kV).eval();
  s.P.middleCols<3>(kP) += dt * s.P.middleCols<3>(kV).eval();
  addVelocityNoise(s.P, config.manoeuvre_noise * config.manoeuvre_noise, dt);
  s.P.diagonal().segment<3>(kR).array() += config.turn_noise * config.turn_noise * dt;
  limitVariance(s.P, kR, kTiltLimit);
  limitVariance(s.P, kR + 1, kTiltLimit);
  limitVariance(s.P, kR + 2, kYawLimit);
  symmetrise(s.P);
  s.t = t;
}

}  // namespace slalom::estimation::detail
