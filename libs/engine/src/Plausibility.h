// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>

#include "Pipeline.h"
#include "slalom/core/DistanceField.h"
#include "slalom/core/MovingObstacle.h"
#include "slalom/core/VehicleState.h"

namespace slalom::engine
{
/** Whether a scan and the map cannot both be right, as when the sensor was mounted wrongly or turns
 * its data around: of the returns at the vehicle's height more than 40 % lie where the map has free
 * space, and of the rays that should end at an obstacle of the map more than 40 % pass through it.
 * What merely appears, or merely goes away, is no contradiction, nor is what ends on a mover: who
 * walks up to the vehicle fills its view. */
[[nodiscard]] bool contradicts(const MapJob& scan, const core::DistanceField& map,
                               std::span<const core::MovingObstacle> movers = {});

/** Notices a position that stays exactly where it is although the vehicle is told to move: a frozen
 * source, or a vehicle that is held fast. Once noticed it stays so until the position moves. */
class StandstillWatch
{
 public:
  void restart() { anchor_L_.reset(), asked_m_ = 0.0; }

  /// @param flown command of the dt seconds before `state`
  void update(const core::VehicleState& state, const core::VelocityCommand& flown, double dt);
  [[nodiscard]] bool stuck() const;

 private:
  std::optional<Eigen::Vector3d> anchor_L_;
  double asked_m_ = 0.0;  // how far the commands would have moved the vehicle since the anchor
};

}  // namespace slalom::engine
