// SPDX-License-Identifier: BSD-3-Clause
#include "slalom/mrpt_io/Geodesy.h"

#include <cmath>
#include <numbers>

namespace slalom::mrpt_io
{
namespace
{
// WGS84: semi-major axis [m] and square of the first eccentricity.
constexpr double kA = 6378137.0, kF = 1.0 / 298.257223563, kE2 = kF * (2.0 - kF);
constexpr double kDegree = std::numbers::pi / 180.0;

double primeVerticalRadius(double latitude)
{
  const double s = std::sin(latitude);
  return kA / std::sqrt(1.0 - kE2 * s * s);
}

Eigen::Vector3d toEcef(const Eigen::Vector3d& geodetic)
{
  const double lat = geodetic.x() * kDegree, lon = geodetic.y() * kDegree, h = geodetic.z();
  const double n = primeVerticalRadius(lat), flat = (n + h) * std::cos(lat);
  return {flat * std::cos(lon), flat * std::sin(lon), (n * (1.0 - kE2) + h) * std::sin(lat)};
}

/// Fixed-point iteration on the latitude; each round gains more than two digits near the ground.
Eigen::Vector3d fromEcef(const Eigen::Vector3d& p)
{
  const double flat = std::hypot(p.x(), p.y());
  double lat = std::atan2(p.z(), flat * (1.0 - kE2)), h = 0.0;
  for (int i = 0; i < 8; ++i)
  {
    const double n = primeVerticalRadius(lat), c = std::cos(lat), s = std::sin(lat);
    // Projection on the local vertical is well conditioned at the equator and at the poles.
    h = flat * c + p.z() * s - n * (1.0 - kE2 * s * s);
    lat = std::atan2(p.z() + kE2 * n * s, flat);
  }
  return {lat / kDegree, std::atan2(p.y(), p.x()) / kDegree, h};
}
}  // namespace

EnuFrame::EnuFrame(const Eigen::Vector3d& datum) : datum_(datum), origin_(toEcef(datum))
{
  const double lat = datum.x() * kDegree, lon = datum.y() * kDegree;
  const double sa = std::sin(lat), ca = std::cos(lat), so = std::sin(lon), co = std::cos(lon);
  R_enu_ecef_ << -so, co, 0.0, -sa * co, -sa * so, ca, ca * co, ca * so, sa;
}

Eigen::Vector3d EnuFrame::toEnu(const Eigen::Vector3d& geodetic) const
{
  return R_enu_ecef_ * (toEcef(geodetic) - origin_);
}

Eigen::Vector3d EnuFrame::toGeodetic(const Eigen::Vector3d& enu) const
{
  return fromEcef(origin_ + R_enu_ecef_.transpose() * enu);
}

}  // namespace slalom::mrpt_io
