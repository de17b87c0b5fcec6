// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

#include "AnalyticField.h"
#include "slalom/core/Rng.h"
#include "slalom/engine/Engine.h"
#include "slalom/simulation/World.h"

namespace slalom::test
{
/// What came out of one closed-loop flight.
struct FlightOutcome
{
  engine::EngineStatus status = engine::EngineStatus::NoMission;
  double min_clearance_m = 1e9;  ///< true distance of the vehicle's centre to the nearest obstacle
  double mean_error_m = 0.0;     ///< to the refined reference
  double duration_s = 0.0, length_m = 0.0;
  double max_speed_mps = 0.0;  ///< per axis
  std::uint64_t hash = 0;
  engine::EngineStatistics statistics;
  bool finite = true;
};

/// Geometry that a vehicle can be flown in.
struct FlightWorld
{
  std::function<double(const Eigen::Vector3d& p)> distance;  ///< [m] to the nearest solid
  /// [m] along a ray of unit direction to the first solid, at most `range`.
  std::function<double(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
                       double range)>
      ray;

  /// By sphere tracing. The field must outlive it.
  static FlightWorld of(const AnalyticField& field)
  {
    const auto distance = [&field](const Eigen::Vector3d& p) { return field.signedDistance(p); };
    return {distance, [distance](const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
                                 double range)
            {
              double along = 0.0;
              while (along < range)
              {
                const double step = distance(origin + along * direction);
                if (step < 1e-3) return along;
                along += step;
              }
              return range;
            }};
  }
  static FlightWorld of(const simulation::World& world)
  {
    return {[&world](const Eigen::Vector3d& p) { return world.distance(p); },
            [&world](const Eigen::Vector3d& origin, const Eigen::Vector3d& direction, double range)
            { return world.castRay(origin, direction, range).value_or(range); }};
  }
};

/** The smallest closed loop: a point vehicle whose velocity follows the command with a lag, exact
 * poses, and a range sensor that sees the analytic world by sphere tracing. Enough to prove that
 * the engine flies; the simulator proper is a library of its own. */
class FlightHarness
{
 public:
  FlightHarness(const AnalyticField& world, const engine::EngineConfig& config)
      : FlightHarness(FlightWorld::of(world), config)
  {
  }
  FlightHarness(FlightWorld world, const engine::EngineConfig& config)
      : world_(std::move(world)), engine_(config)
  {
  }

  int azimuths = 240;  ///< rays per ring; a real VLP-16 has 1800

  bool blind = false;  ///< a broken planner's eyes: every ray reaches its full range

  /// Watches every cycle, with the true position.
  std::function<void(const core::CycleRecord&, const Eigen::Vector3d& p_W)> listener;

  FlightOutcome fly(const Eigen::Vector3d& start, const engine::Mission& mission,
                    double time_limit_s)
  {
    constexpr double kStep = 0.01, kLag = 0.25;
    Eigen::Vector3d p = start, v = Eigen::Vector3d::Zero();
    core::VelocityCommand command;
    double yaw = 0.0, error = 0.0;
    std::uint64_t errors = 0;
    FlightOutcome out;
    engine_.setMission(mission);
    for (int k = 0; k * kStep < time_limit_s; ++k)
    {
      const double t = k * kStep;
      if (k % 2 == 0) engine_.add(pose(t, p, yaw));
      if (k % 10 == 0) engine_.add(scan(t, p, yaw));
      if (k % 5 == 0)
      {
        const core::CycleRecord cycle = engine_.step(t);
        if (listener) listener(cycle, p);
        command = cycle.command;
        out.hash = cycle.decision_hash;
        out.finite &= command.v_W.allFinite() && std::isfinite(command.yaw_rate);
        if (cycle.refined.cols() > 0)
          error += (cycle.refined_point_L - cycle.state.p_L).norm(), ++errors;
        out.status = engine_.status();
        if (out.status == engine::EngineStatus::GoalReached ||
            out.status == engine::EngineStatus::GoalBlocked ||
            out.status == engine::EngineStatus::Unreachable)
          break;
      }
      v += (command.v_W - v) * (kStep / kLag);
      p += v * kStep;
      yaw += command.yaw_rate * kStep;
      out.length_m += v.norm() * kStep;
      out.duration_s = t;
      out.max_speed_mps = std::max(out.max_speed_mps, v.cwiseAbs().maxCoeff());
      out.min_clearance_m = std::min(out.min_clearance_m, world_.distance(p));
    }
    out.mean_error_m = errors ? error / double(errors) : 0.0;
    out.statistics = engine_.statistics();
    return out;
  }

 private:
  static core::PoseFix pose(double t, const Eigen::Vector3d& p, double yaw)
  {
    core::PoseFix fix;
    fix.t = t;
    fix.T_WB = Eigen::Translation3d(p) * core::fromYaw(yaw);
    return fix;
  }

  core::RangeScan scan(double t, const Eigen::Vector3d& p, double yaw) const
  {
    constexpr double kRange = 12.0;
    core::RangeScan scan;
    scan.t = t;
    const Eigen::Quaterniond q_WB = core::fromYaw(yaw);
    for (int azimuth = 0; azimuth < azimuths; ++azimuth)
      for (int ring = -7; ring <= 7; ++ring)
      {
        const double a = azimuth * 2.0 * std::numbers::pi / azimuths,
                     e = ring * 2.0 * std::numbers::pi / 180.0;
        const Eigen::Vector3d d_B(std::cos(e) * std::cos(a), std::cos(e) * std::sin(a),
                                  std::sin(e));
        const Eigen::Vector3d d_W = q_WB * d_B;
        const double range = blind ? kRange : world_.ray(p, d_W, kRange);
        scan.points.push_back({(range * d_B).cast<float>(), 0.0f});
      }
    return scan;
  }

  FlightWorld world_;
  engine::Engine engine_;
};

/// Settings of the closed-loop tests: exact poses, everything else as shipped.
[[nodiscard]] inline engine::EngineConfig flightConfig()
{
  engine::EngineConfig config;
  config.state.source = engine::StateSourceKind::Truth;
  return config;
}

/// Trees on a strip of `length` x 12 m, both ends free.
[[nodiscard]] inline AnalyticField flightForest(std::uint64_t seed, double density_per_m2,
                                                double length)
{
  core::Rng rng(seed);
  std::vector<Obstacle> trees;
  const int count = static_cast<int>(density_per_m2 * length * 12.0);
  while (static_cast<int>(trees.size()) < count)
  {
    const Eigen::Vector2d c(rng.uniform(0.0, length), rng.uniform(-6.0, 6.0));
    const double radius = rng.uniform(0.2, 0.4);
    if (c.norm() > radius + 1.5 && (c - Eigen::Vector2d(length, 0)).norm() > radius + 1.5)
      trees.push_back(VerticalCylinder{c, radius});
  }
  return AnalyticField(std::move(trees));
}

}  // namespace slalom::test
