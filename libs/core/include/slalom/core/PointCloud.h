// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <string>
#include <vector>

namespace slalom::core
{
/// One return of a range sensor, in the sensor's own frame.
struct ScanPoint
{
  Eigen::Vector3f p_S = Eigen::Vector3f::Zero();  ///< [m]
  float dt = 0.0f;                                ///< [s] firing time relative to RangeScan::t
};

/// A decoded scan: every valid return with its firing time. Empty means "no new information", never
/// "all free".
struct RangeScan
{
  double t = 0.0;  ///< [s] log time of the first firing
  std::string label;
  Eigen::Isometry3d T_BS = Eigen::Isometry3d::Identity();  ///< sensor pose on the vehicle
  std::vector<ScanPoint> points;
  /// Firings without an echo among others of the same laser: p_S is a unit direction. Empty if the
  /// sensor does not tell.
  std::vector<ScanPoint> silent;
  double duration = 0.0;  ///< [s] last firing minus first
};

/// A ray from where the sensor was to what it hit, local frame L. What the map fuses.
struct Ray
{
  Eigen::Vector3f origin_L = Eigen::Vector3f::Zero();
  Eigen::Vector3f end_L = Eigen::Vector3f::Zero();
};

}  // namespace slalom::core
