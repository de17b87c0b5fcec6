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

/// Four points, one per column; stands for their convex hull.
using Hull4 = Eigen::Matrix<double, 3, 4>;

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

  /** A number that the distance from any point of the convex hull of four points to any obstacle
   *  point is proved not to be below [m], at most `limit`; e.g. for the Bezier points of a cubic.
   *
   *  Defined for every hull. With UnknownAs::Occupied all space outside bounds() is an obstacle,
   *  with UnknownAs::Free it is free. Fields of voxels measure to the voxels' cubes: for a single
   *  point (four equal columns) the distance exact to 1e-9 m, for a hull of size L less than the
   *  true distance by O(L^2). The default encloses the hull in a ball about boundEverywhere(). */
  [[nodiscard]] virtual double hullBound(const Hull4& hull_L, UnknownAs unknown,
                                         double limit) const;

  /** Appends the centres of the obstacle voxels inside `box_L`: those that are Occupied, and with
   *  UnknownAs::Occupied all that are not Free. Fields without voxels append obstacle samples not
   *  farther apart than resolution(). Nothing outside bounds() is listed: whoever takes unknown
   *  space for an obstacle has to stay inside bounds() by other means. */
  virtual void collectObstacles(const Eigen::AlignedBox3d& box_L, UnknownAs unknown,
                                std::vector<Eigen::Vector3d>& centres_L) const = 0;

  [[nodiscard]] virtual Eigen::AlignedBox3d bounds() const = 0;  ///< [m] known window
  [[nodiscard]] virtual double resolution() const = 0;           ///< [m] voxel edge
  [[nodiscard]] virtual double maxDistance() const = 0;          ///< [m] saturation
  [[nodiscard]] virtual double stamp() const
  {
    return 0.0;
  }  ///< [s] log time of the newest data in it
  [[nodiscard]] virtual std::uint64_t sequence() const { return 0; }

  /** lowerBound() continued to all space [m]: a proved bound on the distance to every obstacle
   *  point, where outside bounds() all is obstacle (UnknownAs::Occupied) or all is free. */
  [[nodiscard]] double boundEverywhere(const Eigen::Vector3d& p_L, UnknownAs unknown) const;

  /// Distance alone; nullopt outside bounds().
  [[nodiscard]] std::optional<double> distance(const Eigen::Vector3d& p_L, UnknownAs unknown) const;
};

}  // namespace slalom::core
