// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <limits>
#include <memory>
#include <vector>

#include "slalom/core/Fields.h"
#include "slalom/core/VehicleState.h"
#include "slalom/simulation/Motion.h"

namespace slalom::simulation
{
/// How a script is flown. INI section [flight].
struct FlightConfig
{
  double speed_mps = 1.2;           ///< [m/s] per axis
  double acceleration_mps2 = 1.0;   ///< [m/s^2] per axis
  double max_yaw_rate_radps = 0.8;  ///< [rad/s]
  double hover_before_s = 2.0;      ///< [s]
  double hover_after_s = 1.0;       ///< [s]

  template <class Self, class Visit>
  static void fields(Self& c, Visit&& v)
  {
    using core::Range;
    v("speed_mps", c.speed_mps, Range{0.05, 30.0}, "speed limit per axis between waypoints");
    v("acceleration_mps2", c.acceleration_mps2, Range{0.05, 9.0}, "acceleration limit per axis");
    v("max_yaw_rate_radps", c.max_yaw_rate_radps, Range{0.05, 10.0}, "yaw rate limit");
    v("hover_before_s", c.hover_before_s, Range{0.0, 60.0}, "standstill before the first metre");
    v("hover_after_s", c.hover_after_s, Range{0.0, 60.0}, "standstill after the last metre");
  }
};

/// A waypoint; yaw NaN: head along the path.
struct Waypoint
{
  Eigen::Vector3d p_W = Eigen::Vector3d::Zero();          ///< [m]
  double yaw = std::numeric_limits<double>::quiet_NaN();  ///< [rad]
};

/// Poses of a TUM file, `t x y z qx qy qz qw` a line.
/// @throws std::runtime_error naming file, line and value
[[nodiscard]] std::vector<core::TimedPose> readTum(const std::filesystem::path& file);

/** A flight along a script, from rest to rest, with the attitude of a multirotor: the thrust
 * direction follows from the acceleration, the heading is smooth and rate-limited. Time 0 is the
 * start of the recording. Position is twice differentiable and the specific force integrates back
 * to it. */
class ScriptedFlight : public Motion
{
 public:
  /// Waypoints through spline::fitWaypoints; heads along the path, or to the waypoints' yaws if
  /// they have any. @throws std::invalid_argument as fitWaypoints does
  [[nodiscard]] static ScriptedFlight through(const std::vector<Waypoint>& waypoints,
                                              const FlightConfig& config);

  /** Through recorded poses in their own time, by a natural cubic spline over position and heading
   * (poses nearer than 0.1 s in time are thinned out). The tilt is the multirotor's, not the
   * recording's. The standstills are added where the recording begins or ends at rest (below 0.1
   * m/s).
   *  @throws std::invalid_argument on fewer than two poses or times that do not increase */
  [[nodiscard]] static ScriptedFlight along(const std::vector<core::TimedPose>& poses,
                                            const FlightConfig& config);

  /// Waypoints (spline/WaypointFile.h) or a TUM file, told apart by their content. @throws
  /// std::runtime_error
  [[nodiscard]] static ScriptedFlight load(const std::filesystem::path& file,
                                           const FlightConfig& config);

  ~ScriptedFlight() override;
  ScriptedFlight(ScriptedFlight&&) noexcept;
  ScriptedFlight& operator=(ScriptedFlight&&) noexcept;

  [[nodiscard]] double duration() const;  ///< [s] standstills included
  [[nodiscard]] Eigen::Isometry3d pose(double t) const override;
  [[nodiscard]] MotionSample at(double t) const override;

  struct Path;  ///< position and heading over time; internal

 private:
  explicit ScriptedFlight(std::unique_ptr<const Path> path);
  std::unique_ptr<const Path> path_;
};

}  // namespace slalom::simulation
