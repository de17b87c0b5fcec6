// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <limits>

namespace slalom::estimation::detail
{
/// Blocks of the 15 error states. Rotation errors are in world axes: R_true = Exp(theta) R.
enum Block : int
{
  kP = 0,
  kV = 3,
  kR = 6,
  kBg = 9,
  kBa = 12
};
using Matrix15 = Eigen::Matrix<double, 15, 15>;
using Vector15 = Eigen::Matrix<double, 15, 1>;

constexpr double kGravity = 9.80665;  // [m/s^2]
constexpr double kNever = -std::numeric_limits<double>::infinity();
/// Measurement sources told apart by the gate; further ones share the last slot.
constexpr int kSlots = 16;

/** Everything a filter knows after an event. It is a function of the time-ordered events alone (so
 * that a replay with a late measurement gives what the right order would have given); that is why
 * the gate's memory and the likelihood live here too. */
struct FilterState
{
  double t = 0.0;
  Eigen::Vector3d p = Eigen::Vector3d::Zero();
  Eigen::Vector3d v = Eigen::Vector3d::Zero();
  Eigen::Quaterniond q = Eigen::Quaterniond::Identity();
  Eigen::Vector3d bg = Eigen::Vector3d::Zero();
  Eigen::Vector3d ba = Eigen::Vector3d::Zero();
  Eigen::Vector3d w_B = Eigen::Vector3d::Zero();  ///< last angular rate, bias removed
  Eigen::Vector3d a_W = Eigen::Vector3d::Zero();  ///< acceleration, lightly smoothed
  double manoeuvre2 = 0.0;  ///< [m^2/s^4] fading mean square of its horizontal part
  Matrix15 P = Matrix15::Identity();

  std::array<std::uint16_t, kSlots> rejects{};  ///< consecutive, per source
  std::uint32_t resets = 0;
  double log_likelihood = 0.0;    ///< of all innovations, accepted or not
  double last_position = kNever;  ///< times of the last accepted measurement of a kind
  double last_velocity = kNever;
  double last_body_velocity = kNever;
  double last_heading = kNever;
  double last_rotation = kNever;
  double last_imu = kNever;
};

}  // namespace slalom::estimation::detail
