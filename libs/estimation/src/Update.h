// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "FilterState.h"
#include "slalom/estimation/FilterConfig.h"

namespace slalom::estimation::detail
{
enum class AidKind
{
  Position,
  Velocity,
  BodyVelocity,
  Yaw,
  Pose,
  Gravity  ///< direction of "up" in the body, from a mean specific force
};

/// Any measurement that corrects the filter, in one shape.
struct Aid
{
  double t = 0.0;
  AidKind kind = AidKind::Position;
  int slot = 0;                                           ///< gate memory of its source
  Eigen::Vector3d z = Eigen::Vector3d::Zero();            ///< value; yaw in z.x()
  Eigen::Vector3d sigma = Eigen::Vector3d::Ones();        ///< infinite: axis not measured
  Eigen::Vector3d lever_B = Eigen::Vector3d::Zero();      ///< Position only
  Eigen::Quaterniond q = Eigen::Quaterniond::Identity();  ///< Pose only
  double sigma_rotation = 0.0;                            ///< Pose only [rad]
};

enum class Outcome
{
  Accepted,
  Gated,
  Undefined  ///< says nothing here: heading of a vertical nose, no measured axis
};

/** Kalman update with a chi-square gate per source, in Joseph form. After config.max_rejects
 * consecutive rejects of a source the filter is re-initialised on it, as far as the source speaks:
 * it is then the filter that is wrong.
 *  @param gate  threshold at 3 degrees of freedom; fewer degrees get the same probability */
Outcome applyAid(FilterState& state, const Aid& aid, const FilterConfig& config, double gate);

/** Without IMU and heading source a vehicle is taken to fly nose first, loosely: heading = course
 * of the estimated velocity. Does nothing at low speed. */
void applyCourse(FilterState& state, const FilterConfig& config);

}  // namespace slalom::estimation::detail
