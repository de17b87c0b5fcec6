// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>

#include "slalom/core/VehicleState.h"
#include "slalom/engine/EngineConfig.h"
#include "slalom/engine/Mission.h"
#include "slalom/spline/TimeLaw.h"
#include "slalom/spline/UniformBSpline.h"

namespace slalom::engine
{
/// One mission in flight. R is fitted in the world frame once and follows the drift of the local
/// frame slowly.
struct Flight
{
  /// @param blind R may have to be flown without a map, so that it needs a time law of its own
  Flight(std::uint64_t mission_number, spline::UniformBSpline reference,
         const Eigen::Vector3d& frame_offset, const core::Vehicle& planned, bool blind);

  /// Moves R to another offset of the local frame against the world [m].
  void moveTo(const Eigen::Vector3d& new_offset);

  std::uint64_t number;
  spline::UniformBSpline reference_W;
  std::shared_ptr<const spline::UniformBSpline> reference_L;
  std::shared_ptr<const spline::TimeLaw> law;  ///< of R itself; null: not blind
  Eigen::Vector3d offset;                      ///< L minus W, as used for reference_L
  double length;                               ///< [m]
  bool only_goal = false;                      ///< the mission names a goal and no way to it
  bool reached = false;
};

/** R for a mission that begins where the vehicle is: from its position over the waypoints that lie
 * ahead. A vehicle at a waypoint, or already under way on one of the first legs, does not fly back
 * to their beginning.
 *  @throws std::invalid_argument if check() of the whole mission does */
[[nodiscard]] spline::UniformBSpline fitReference(const Mission& mission,
                                                  const core::VehicleState& state,
                                                  const EngineConfig& config);

}  // namespace slalom::engine
