// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "Objects.h"
#include "RangeHistory.h"
#include "slalom/core/MovingObstacle.h"

namespace slalom::tracking::detail
{
/// Where a tracked object was, with some of its returns.
struct Footprint
{
  static constexpr std::size_t kEnds = 32;

  double t = 0.0;
  Eigen::Vector3d centre_L = Eigen::Vector3d::Zero();
  double half_width_m = 0.0, half_height_m = 0.0;
  std::size_t count = 0;
  std::array<Eigen::Vector3f, kEnds> ends_L;
};

/** One object over time: a Kalman filter of constant velocity (state p, v; the three axes
 *  independent), its size, and its last footprints. */
class Track
{
 public:
  Track(std::uint64_t id, const TrackingConfig& config, double t, const Object& object);

  void predict(double t);
  void correct(const Object& object, double range_m);
  void remember(std::span<const core::Ray> rays, const Object& object);

  /** How much the scans say that space has changed because this object has moved: the share of its
   *  returns that lie where rays had passed, plus the share of its former returns where rays pass
   *  now; nullopt if too little of either has been looked at. */
  [[nodiscard]] std::optional<double> evidence(const RangeHistory& history,
                                               std::span<const core::Ray> rays,
                                               const Object& object) const;

  /// Whether it has come far and fast enough to be a mover, if there is evidence, too.
  [[nodiscard]] bool fastEnough() const;

  /// Time within which a mover of this speed leaves its place far enough to be seen to [s].
  [[nodiscard]] double lag() const;

  /// The newest footprint at least so old.
  [[nodiscard]] const Footprint* footprintBefore(double t) const;
  [[nodiscard]] int footprints() const { return stored_; }
  /// Newest first.
  [[nodiscard]] const Footprint& footprint(int age) const
  {
    return footprints_[static_cast<std::size_t>((newest_ - age + kFootprints) % kFootprints)];
  }

  /// The track as predicted for a time.
  [[nodiscard]] core::MovingObstacle at(double t) const;

  [[nodiscard]] double gate() const;  ///< [m] for the next measured centre
  [[nodiscard]] double speed() const { return v_L.head<2>().norm(); }

  std::uint64_t id;
  double t, seen;  ///< [s] of the state, and of the last measurement
  double last_fast;
  bool confirmed = false;
  int score = 0;  ///< scans in favour of motion, less those against
  Eigen::Vector3d p_L, v_L = Eigen::Vector3d::Zero();
  double half_width_m, half_height_m;
  double largest_m = 0.0;  ///< [m] half width that it may have, since it was confirmed

 private:
  // Covariance of position and velocity along one axis.
  struct Covariance
  {
    double pp, pv, vv;
    void predict(double dt, double sigma_acceleration);
    // Returns the gains of position and velocity.
    std::pair<double, double> correct(double variance);
  };
  static constexpr int kFootprints = 20;

  double tallest_m_;  // half of the height once seen
  TrackingConfig config_;
  Covariance plane_, height_;
  double ring_gap_m_ = 0.0;  // height that rings may have missed at each end
  int newest_ = 0, stored_ = 0;
  std::array<Footprint, kFootprints> footprints_;
};

}  // namespace slalom::tracking::detail
