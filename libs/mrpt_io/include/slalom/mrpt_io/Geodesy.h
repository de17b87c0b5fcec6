// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

namespace slalom::mrpt_io
{
/** East-north-up coordinates around a datum on the WGS84 ellipsoid, exact both ways (below 1 um
 * within 100 km). MRPT 2.5.8's ENUToGeocentric() is not the inverse of its geodeticToENU_WGS84().
 */
class EnuFrame
{
 public:
  /// @param datum latitude, longitude [deg], height [m]
  explicit EnuFrame(const Eigen::Vector3d& datum);

  /// @param geodetic latitude, longitude [deg], height [m] @return east, north, up [m]
  [[nodiscard]] Eigen::Vector3d toEnu(const Eigen::Vector3d& geodetic) const;
  /// The inverse of toEnu().
  [[nodiscard]] Eigen::Vector3d toGeodetic(const Eigen::Vector3d& enu) const;
  [[nodiscard]] const Eigen::Vector3d& datum() const { return datum_; }

 private:
  Eigen::Vector3d datum_, origin_;  ///< geodetic, geocentric
  Eigen::Matrix3d R_enu_ecef_;
};

}  // namespace slalom::mrpt_io
