// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cmath>
#include <deque>
#include <functional>
#include <numbers>
#include <utility>

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
    return of([&field](const Eigen::Vector3d& p) { return field.signedDistance(p); });
  }
  static FlightWorld of(const std::function<double(const Eigen::Vector3d& p)>& distance)
  {
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

/// What goes wrong between the parts of the loop. Empty members break nothing.
struct FaultInjector
{
  /// Between sensors and engine: may change a measurement; false: it is lost.
  std::function<bool(core::Measurement& measurement)> sensor;
  /// Between engine and vehicle: may change the command.
  std::function<void(double t, core::VelocityCommand& command)> command;
  /// The host, before every cycle: its verbs. False: the vehicle is not to be driven (suspended).
  std::function<bool(double t, engine::Engine& engine)> host;
  /// The world, before every cycle: what appears, and where.
  std::function<void(double t, const Eigen::Vector3d& p_W)> world;
};

/** The smallest closed loop: a point vehicle whose velocity follows the command with a lag, exact
 * poses, and a range sensor that sees the analytic world by sphere tracing. Enough to prove that
 * the engine flies; the simulator proper is a library of its own. */
class FlightHarness
{
 public:
  FlightHarness(const AnalyticField& world, const engine::EngineConfig& config,
                engine::StepHooks hooks = {})
      : FlightHarness(FlightWorld::of(world), config, std::move(hooks))
  {
  }
  FlightHarness(FlightWorld world, const engine::EngineConfig& config, engine::StepHooks hooks = {})
      : world_(std::move(world)), engine_(config, std::move(hooks))
  {
  }

  static constexpr double kLag = 0.25;  ///< [s] of the vehicle's velocity behind the command

  int azimuths = 240;   ///< rays per ring; a real VLP-16 has 1800
  int cycle_steps = 5;  ///< hundredths of a second from one cycle to the next

  bool blind = false;  ///< a broken planner's eyes: every ray reaches its full range

  double command_delay_s = 0.0;  ///< the vehicle's; the engine knows what it is configured with
  bool fusion = false;           ///< noisy IMU, GPS, velocity and compass instead of exact poses
  FaultInjector faults;

  /// Watches every cycle, with the true position.
  std::function<void(const core::CycleRecord&, const Eigen::Vector3d& p_W)> listener;
  /// Whether a flight with this status is over.
  std::function<bool(double t, engine::EngineStatus)> over = [](double, engine::EngineStatus status)
  {
    return status == engine::EngineStatus::GoalReached ||
           status == engine::EngineStatus::GoalBlocked ||
           status == engine::EngineStatus::Unreachable ||
           status == engine::EngineStatus::SensorLost;
  };

  FlightOutcome fly(const Eigen::Vector3d& start, const engine::Mission& mission,
                    double time_limit_s)
  {
    vehicle_ = {};
    vehicle_.p = start;
    out_ = {};
    std::uint64_t errors = 0;
    engine_.setMission(mission);
    for (int k = 0; k * kStep < time_limit_s; ++k)
    {
      const double t = k * kStep;
      sense(k);
      if (k % cycle_steps == 0)
      {
        const core::CycleRecord cycle = decide(t);
        if (cycle.refined.cols() > 0)
          out_.mean_error_m += (cycle.refined_point_L - cycle.state.p_L).norm(), ++errors;
        if (over(t, out_.status)) break;
      }
      move(t);
    }
    if (errors) out_.mean_error_m /= double(errors);
    out_.statistics = engine_.statistics();
    return out_;
  }

  /// Of the vehicle now; for faults that depend on it.
  [[nodiscard]] const Eigen::Vector3d& position() const { return vehicle_.p; }
  [[nodiscard]] const Eigen::Vector3d& velocity() const { return vehicle_.v; }

 private:
  static constexpr double kStep = 0.01;

  struct Vehicle
  {
    Eigen::Vector3d p = Eigen::Vector3d::Zero(), v = p, a = p;
    double yaw = 0.0;
    core::VelocityCommand command;                                   // in effect
    std::deque<std::pair<double, core::VelocityCommand>> under_way;  // by time of effect
  };

  void sense(int k)
  {
    const double t = k * kStep;
    const Vehicle& now = vehicle_;
    if (fusion)
      senseNoisily(k, t);
    else if (k % 2 == 0)
      give(pose(t, now.p, now.yaw));
    if (k % 10 == 0) give(scan(t, now.p, now.yaw));
  }

  void senseNoisily(int k, double t)
  {
    const Vehicle& now = vehicle_;
    const auto noisy = [this](const Eigen::Vector3d& v, double sigma) -> Eigen::Vector3d
    { return v + rng_.normal3(sigma); };
    const Eigen::Vector3d gravity(0.0, 0.0, 9.80665);
    core::ImuSample imu;
    imu.t = t;
    imu.f_B = noisy(core::fromYaw(now.yaw).conjugate() * (now.a + gravity), 0.2);
    imu.w_B = noisy({0.0, 0.0, now.command.yaw_rate}, 0.01);
    give(imu);
    if (k % 5 == 2)
    {
      core::VelocityFix fix;
      fix.t = t;
      fix.v = noisy(now.v, 0.05);
      fix.sigma.setConstant(0.05);
      fix.source = "velocity";
      give(fix);
    }
    if (k % 10 == 3) give(core::YawFix{t, now.yaw + rng_.normal() * 0.03, 0.03, "compass"});
    if (k % 20 == 4)
    {
      core::PositionFix fix;
      fix.t = t;
      fix.p_W = noisy(now.p, 0.2);
      fix.sigma.setConstant(0.2);
      fix.source = "gps";
      give(fix);
    }
  }

  void give(core::Measurement measurement)
  {
    if (!faults.sensor || faults.sensor(measurement)) engine_.add(measurement);
  }

  core::CycleRecord decide(double t)
  {
    if (faults.world) faults.world(t, vehicle_.p);
    const bool drive = !faults.host || faults.host(t, engine_);
    core::CycleRecord cycle = engine_.step(t, drive);
    if (listener) listener(cycle, vehicle_.p);
    out_.hash = cycle.decision_hash;
    out_.finite &= cycle.command.v_W.allFinite() && std::isfinite(cycle.command.yaw_rate);
    out_.status = engine_.status();
    core::VelocityCommand command = cycle.command;
    if (faults.command) faults.command(t, command);
    vehicle_.under_way.emplace_back(t + command_delay_s, command);
    return cycle;
  }

  void move(double t)
  {
    Vehicle& now = vehicle_;
    for (; !now.under_way.empty() && now.under_way.front().first <= t + 0.1 * kStep;
         now.under_way.pop_front())
      now.command = now.under_way.front().second;
    now.a = (now.command.v_W - now.v) / kLag;
    now.v += now.a * kStep;
    now.p += now.v * kStep;
    now.yaw += now.command.yaw_rate * kStep;
    out_.length_m += now.v.norm() * kStep;
    out_.duration_s = t;
    out_.max_speed_mps = std::max(out_.max_speed_mps, now.v.cwiseAbs().maxCoeff());
    out_.min_clearance_m = std::min(out_.min_clearance_m, world_.distance(now.p));
  }

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
  core::Rng rng_{1};
  Vehicle vehicle_;
  FlightOutcome out_;
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
