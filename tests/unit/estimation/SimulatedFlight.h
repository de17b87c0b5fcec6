// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <variant>
#include <vector>

#include "slalom/core/Math.h"
#include "slalom/core/Measurements.h"
#include "slalom/core/Rng.h"
#include "slalom/estimation/StateEstimator.h"

namespace slalom::test
{
/// A multi-rotor's motion: thrust along the mast, so attitude follows from acceleration and yaw.
class FlightPath
{
 public:
  std::function<Eigen::Vector3d(double)> position;
  std::function<double(double)> yaw = [](double) { return 0.0; };

  /// Loops of a few metres with turns, faster than walking; at rest until `take_off`.
  static FlightPath loops(double take_off, double speed = 1.0)
  {
    FlightPath path;
    const auto clock = [take_off, speed](double t)
    {
      // C3 start: the integral of a smooth step of 2 s.
      const double u = std::clamp((t - take_off) / 2.0, 0.0, 1.0);
      const double ramp = u * u * u * u * (2.5 + u * (-3.0 + u));
      return speed * (2.0 * ramp + std::max(0.0, t - take_off - 2.0));
    };
    path.position = [clock](double t)
    {
      const double s = clock(t);
      return Eigen::Vector3d(6.0 * std::sin(0.5 * s), 5.0 * (1.0 - std::cos(0.4 * s)),
                             1.5 * (1.0 - std::cos(0.3 * s)));
    };
    path.yaw = [clock](double t) { return 0.7 + 0.8 * std::sin(0.35 * clock(t)); };
    return path;
  }
  static FlightPath hover(const Eigen::Vector3d& p = Eigen::Vector3d::Zero(), double heading = 0.0)
  {
    FlightPath path;
    path.position = [p](double) { return p; };
    path.yaw = [heading](double) { return heading; };
    return path;
  }

  Eigen::Vector3d velocity(double t) const
  {
    return (position(t + kH) - position(t - kH)) / (2.0 * kH);
  }
  Eigen::Vector3d acceleration(double t) const
  {
    return (position(t + kH) - 2.0 * position(t) + position(t - kH)) / (kH * kH);
  }
  Eigen::Vector3d force(double t) const
  {
    return acceleration(t) + 9.80665 * Eigen::Vector3d::UnitZ();
  }
  Eigen::Quaterniond attitude(double t) const
  {
    const Eigen::Vector3d z = force(t).normalized();
    const Eigen::Vector3d nose(std::cos(yaw(t)), std::sin(yaw(t)), 0.0);
    Eigen::Matrix3d R;
    R.col(2) = z;
    R.col(1) = z.cross(nose).normalized();
    R.col(0) = R.col(1).cross(z);
    return Eigen::Quaterniond(R);
  }
  Eigen::Vector3d rate(double t) const
  {
    const Eigen::AngleAxisd turn(attitude(t - kH).conjugate() * attitude(t + kH));
    return turn.angle() * turn.axis() / (2.0 * kH);
  }

 private:
  static constexpr double kH = 1e-3;
};

/// Sensors whose noise is what FilterConfig's defaults say.
struct SensorSuite
{
  double duration = 20.0;
  double imu_hz = 100.0;
  double gps_hz = 5.0;
  Eigen::Vector3d gps_sigma{0.5, 0.5, 0.8};
  Eigen::Vector3d lever_B = Eigen::Vector3d::Zero();
  double gps_delay = 0.0;
  double velocity_hz = 20.0;
  double velocity_sigma = 0.1;
  bool velocity_in_body = false;
  double yaw_hz = 0.0;
  double yaw_sigma = 0.05;
  double bias_scale = 1.0;
  double imu_noise_scale = 1.0;
};

struct Arrival
{
  double at = 0.0;
  core::Measurement measurement;
};

inline std::vector<Arrival> simulate(const FlightPath& path, const SensorSuite& suite,
                                     std::uint64_t seed, const estimation::FilterConfig& c = {})
{
  core::Rng rng(seed);
  std::vector<Arrival> out;
  const Eigen::Vector3d ba = rng.normal3(suite.bias_scale * c.accel_bias_sigma);
  const Eigen::Vector3d bg = rng.normal3(suite.bias_scale * c.gyro_bias_sigma);
  const double root = suite.imu_noise_scale * std::sqrt(suite.imu_hz);
  const auto every = [&](double hz, double phase, const auto& make)
  {
    if (hz <= 0.0) return;
    for (int i = 0; i / hz + phase <= suite.duration; ++i) make(i / hz + phase);
  };
  every(suite.imu_hz, 0.0,
        [&](double t)
        {
          const Eigen::Vector3d f = path.attitude(t).conjugate() * path.force(t);
          out.push_back({t, core::ImuSample{t, f + ba + rng.normal3(root * c.accel_noise),
                                            path.rate(t) + bg + rng.normal3(root * c.gyro_noise)}});
        });
  every(suite.gps_hz, 0.013,
        [&](double t)
        {
          core::PositionFix fix;
          fix.t = t;
          fix.p_W = path.position(t) + path.attitude(t) * suite.lever_B +
                    rng.normal3(1.0).cwiseProduct(suite.gps_sigma);
          fix.sigma = suite.gps_sigma;
          fix.lever_B = suite.lever_B;
          fix.source = "gps";
          out.push_back({t + suite.gps_delay, fix});
        });
  every(suite.velocity_hz, 0.007,
        [&](double t)
        {
          core::VelocityFix fix;
          fix.t = t;
          fix.v = path.velocity(t);
          if (suite.velocity_in_body) fix.v = path.attitude(t).conjugate() * fix.v;
          fix.v += rng.normal3(suite.velocity_sigma);
          fix.sigma.setConstant(suite.velocity_sigma);
          fix.in_body = suite.velocity_in_body;
          fix.source = "velocity";
          out.push_back({t, fix});
        });
  every(suite.yaw_hz, 0.003,
        [&](double t)
        {
          const double yaw = core::yawOf(path.attitude(t));
          out.push_back({t, core::YawFix{t, yaw + suite.yaw_sigma * rng.normal(), suite.yaw_sigma,
                                         "compass"}});
        });
  std::stable_sort(out.begin(), out.end(),
                   [](const Arrival& a, const Arrival& b) { return a.at < b.at; });
  return out;
}

inline void feed(estimation::StateEstimator& estimator, const core::Measurement& measurement)
{
  std::visit(
      [&](const auto& m)
      {
        if constexpr (!std::is_same_v<std::decay_t<decltype(m)>, core::RangeScan>) estimator.add(m);
      },
      measurement);
}

/// Error [p, v, rotation in world axes] of a state against the path.
inline Eigen::Matrix<double, 9, 1> errorOf(const core::VehicleState& s, const FlightPath& path)
{
  const Eigen::AngleAxisd turn(path.attitude(s.t) * s.q_WB.conjugate());
  Eigen::Matrix<double, 9, 1> e;
  e << path.position(s.t) - s.p_W, path.velocity(s.t) - s.v_W, turn.angle() * turn.axis();
  return e;
}

}  // namespace slalom::test
