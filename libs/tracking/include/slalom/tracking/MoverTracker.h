// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "slalom/core/DistanceField.h"
#include "slalom/core/MovingObstacle.h"
#include "slalom/core/PointCloud.h"
#include "slalom/core/Sphere.h"
#include "slalom/tracking/TrackingConfig.h"

namespace slalom::tracking
{
struct TrackerOutput
{
  std::vector<core::MovingObstacle> movers;  ///< confirmed; whatever is at rest is the map's
  std::vector<std::uint8_t>
      on_mover;                      ///< one per ray: 1 = it ends on a confirmed or suspected mover
  std::vector<core::Sphere> ghosts;  ///< where the map may still hold voxels of a mover
  int objects = 0;                   ///< compact things in this scan, at rest or not
};

/** Finds what moves in the scans of a range sensor and tracks it.
 *
 *  Returns are grouped into compact objects, which are tracked with a Kalman filter of constant
 *  velocity. That an object moves is claimed only with proof of changed space: its returns lie
 * where rays of earlier scans passed freely, or rays now pass where its former returns lay. An
 * object at rest gives neither, from wherever it is seen and whatever hides parts of it. When most
 * objects seem to move at once, the vehicle's own position is at fault and nothing is confirmed.
 *
 *  Deterministic; never throws after construction; not thread-safe. */
class MoverTracker
{
 public:
  /// @throws std::invalid_argument naming key, value and bound
  explicit MoverTracker(const TrackingConfig& config);
  ~MoverTracker();
  MoverTracker(MoverTracker&&) noexcept;
  MoverTracker& operator=(MoverTracker&&) noexcept;

  /** Takes one scan, or a part of one. Scans not newer than the last are ignored, and so are rays
   *  that are not finite.
   *  @param t     [s] log time
   *  @param p_L   [m] position of the vehicle
   *  @param map   the map before this scan, or nullptr: keeps movers apart from what they pass by
   */
  TrackerOutput update(double t, const Eigen::Vector3d& p_L, std::span<const core::Ray> rays,
                       const core::DistanceField* map);

  /// The movers as predicted for a time t [s]: less certain the longer they are unseen, then gone.
  [[nodiscard]] std::vector<core::MovingObstacle> at(double t) const;

  void reset();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace slalom::tracking
