// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <optional>
#include <vector>

namespace slalom::core
{
/// Space has three values; "not known" is never silently free.
enum class Occupancy : std::uint8_t
{
  Unknown,
  Free,
  Occupied
};

/// How a distance query treats unknown space.
enum class UnknownAs : std::uint8_t
{
  Free,     ///< optimistic: only seen obstacles count; for guides and preferences
  Occupied  ///< pessimistic: unknown space is an obstacle; for anything committed
};

/// Distance to the nearest obstacle and the direction in which it grows.
struct DistanceSample
{
  double distance = 0.0;  ///< [m]
  Eigen::Vector3d gradient =
      Eigen::Vector3d::Zero();  ///< [1] of the interpolated distance; norm about 1, 0 at ties
};

/** What planners may know of space: an immutable, thread-safe field in the local frame L.
 *
 *  Distances are Euclidean, from the query point to the nearest obstacle surface, saturated at
 * maxDistance(); negative inside obstacles if the field is signed. A query outside bounds() answers
 * std::nullopt, never a number. */
class DistanceField
{
 public:
  virtual ~DistanceField() = default;

  /// Unknown outside bounds().
  [[nodiscard]] virtual Occupancy occupancy(const Eigen::Vector3d& p_L) const = 0;

  /// Smooth (trilinear) distance with its exact gradient; nullopt outside bounds().
  [[nodiscard]] virtual std::optional<DistanceSample> sample(const Eigen::Vector3d& p_L,
                                                             UnknownAs unknown) const = 0;

  /** A number that the true distance to any obstacle point is proved not to be below [m].
   *  Used by certificates: at most sample().distance, at least that minus one voxel diagonal.
   * nullopt outside. */
  [[nodiscard]] virtual std::optional<double> lowerBound(const Eigen::Vector3d& p_L,
                                                         UnknownAs unknown) const = 0;

  /// Appends the centres of occupied voxels (or obstacle samples not farther apart than
  /// resolution()) inside `box_L`.
  virtual void collectOccupied(const Eigen::AlignedBox3d& box_L,
                               std::vector<Eigen::Vector3d>& centres_L) const = 0;

  [[nodiscard]] virtual Eigen::AlignedBox3d bounds() const = 0;  ///< [m] known window
  [[nodiscard]] virtual double resolution() const = 0;           ///< [m] voxel edge
  [[nodiscard]] virtual double maxDistance() const = 0;          ///< [m] saturation
  [[nodiscard]] virtual double stamp() const
  {
    return 0.0;
  }  ///< [s] log time of the newest data in it
  [[nodiscard]] virtual std::uint64_t sequence() const { return 0; }

  /// Distance alone; nullopt outside bounds().
  [[nodiscard]] std::optional<double> distance(const Eigen::Vector3d& p_L, UnknownAs unknown) const;
};

}  // namespace slalom::core
