// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "SharedData.h"
#include "SimulatedFlight.h"

namespace slalom::test
{
using Table = std::vector<std::vector<double>>;

/// Rows of numbers below one header line; what is not a number becomes NaN.
inline Table readCsv(const std::filesystem::path& file)
{
  Table rows;
  std::ifstream in(file);
  std::string line;
  std::getline(in, line);
  while (std::getline(in, line))
  {
    std::vector<double> row;
    std::stringstream cells(line);
    for (std::string cell; std::getline(cells, cell, ',');)
    {
      char* end = nullptr;
      const double value = std::strtod(cell.c_str(), &end);
      row.push_back(end == cell.c_str() ? std::nan("") : value);
    }
    rows.push_back(row);
  }
  return rows;
}

inline Eigen::Vector3d flu(double x, double y, double z)
{
  return {x, -y, -z};
}
inline Eigen::Vector3d enu(double n, double e, double d)
{
  return {e, n, -d};
}

/// Attitude of FLU in ENU from one of FRD in NED.
inline Eigen::Quaterniond fromAerospace(double w, double x, double y, double z)
{
  Eigen::Matrix3d ned_to_enu;
  ned_to_enu << 0, 1, 0, 1, 0, 0, 0, 0, -1;
  const Eigen::Matrix3d frd_to_flu = Eigen::Vector3d(1, -1, -1).asDiagonal();
  const Eigen::Matrix3d R = Eigen::Quaterniond(w, x, y, z).normalized().toRotationMatrix();
  return Eigen::Quaterniond(Eigen::Matrix3d(ned_to_enu * R * frd_to_flu));
}

/// East, north, up in a tangent plane; good to centimetres within a kilometre.
class TangentPlane
{
 public:
  TangentPlane(double lat_deg, double lon_deg, double alt) : lat_(lat_deg), lon_(lon_deg), alt_(alt)
  {
    const double s = std::sin(lat_ * kRadian);
    const double w2 = 1.0 - 6.69437999014e-3 * s * s;
    const double prime_vertical = 6378137.0 / std::sqrt(w2);
    north_ = prime_vertical * (1.0 - 6.69437999014e-3) / w2 * kRadian;
    east_ = prime_vertical * std::cos(lat_ * kRadian) * kRadian;
  }
  Eigen::Vector3d operator()(double lat_deg, double lon_deg, double alt) const
  {
    return {(lon_deg - lon_) * east_, (lat_deg - lat_) * north_, alt - alt_};
  }

 private:
  static constexpr double kRadian = 3.14159265358979323846 / 180.0;
  double lat_, lon_, alt_, north_ = 0.0, east_ = 0.0;
};

inline void appendImu(std::vector<Arrival>& out, const std::filesystem::path& file)
{
  for (const auto& r : readCsv(file))
    out.push_back({r[0], core::ImuSample{r[0], flu(r[1], r[2], r[3]), flu(r[4], r[5], r[6])}});
}

/// @param lag  [s] how late the receiver stamps its fixes; 0 takes the log at its word
inline void appendGps(std::vector<Arrival>& out, const std::filesystem::path& file,
                      const TangentPlane& plane, double lag)
{
  for (const auto& r : readCsv(file))
  {
    if (!(r[10] >= 3)) continue;
    const auto known = [](double value, double otherwise)
    { return value > 0.0 ? value : otherwise; };
    core::PositionFix p;
    p.t = r[0] - lag;
    p.p_W = plane(r[1], r[2], r[3]);
    const double eph = known(r[7], 0.8);
    p.sigma = {eph, eph, known(r[8], 1.5)};
    p.source = "gps";
    out.push_back({r[0], p});
    core::VelocityFix v;
    v.t = r[0] - lag;
    v.v = enu(r[4], r[5], r[6]);
    v.sigma.setConstant(known(r[9], 0.3));
    v.source = "gps";
    out.push_back({r[0], v});
  }
}

inline void sortByArrival(std::vector<Arrival>& arrivals)
{
  std::stable_sort(arrivals.begin(), arrivals.end(),
                   [](const Arrival& a, const Arrival& b) { return a.at < b.at; });
}

/// Horizontal and heading errors, accumulated.
struct ErrorSum
{
  double squares = 0.0, worst = 0.0, yaw_squares = 0.0;
  int n = 0;
  void add(const Eigen::Vector3d& error, double yaw_error = 0.0)
  {
    squares += error.head<2>().squaredNorm();
    worst = std::max(worst, error.head<2>().norm());
    yaw_squares += yaw_error * yaw_error;
    ++n;
  }
  double rms() const { return std::sqrt(squares / n); }
  double yawRmsDeg() const { return std::sqrt(yaw_squares / n) * 57.29577951; }
};

}  // namespace slalom::test
