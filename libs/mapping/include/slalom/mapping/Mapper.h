// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>

#include "slalom/core/DistanceField.h"
#include "slalom/core/PointCloud.h"
#include "slalom/core/Sphere.h"
#include "slalom/mapping/EdtSnapshot.h"
#include "slalom/mapping/MapperConfig.h"

namespace slalom::mapping
{
/// What one update did.
struct MapUpdate
{
  int rays = 0;               ///< fused
  int rays_out_of_range = 0;  ///< ended beyond update_range: carved up to it only
  int rays_on_movers = 0;     ///< cleared up to their end only
  int cells_changed = 0;      ///< cells whose Free/Occupied/Unknown class changed
  double integrate_s = 0.0,
         transform_s = 0.0;  ///< [s] wall time of ray casting and of the distance transform
};

/// What of a scan is not part of the static world.
struct MoverMask
{
  /// One per ray; those that are not 0 end on a mover, or on nothing: they clear space before their
  /// end and mark nothing.
  std::span<const std::uint8_t> on_mover;
  /** Where a mover was. Occupied cells with their centres inside return to unknown, not to free: a
   * wall that it brushed past stays an obstacle to whoever flies with UnknownAs::Occupied, and the
   * first ray through a cell, usually of the same scan, frees it. */
  std::span<const core::Sphere> ghosts;
};

/** The mapper of the paper: OctoMap fused from scans inside `update_range`, a Euclidean distance
 * transform on top.
 *
 *  Rays are cast in a dense log-odds window that rolls with the vehicle; cells that change are
 * written to the octree of record. Each integrate() publishes a new immutable EdtSnapshot. One
 * writer; snapshots are thread-safe. An empty scan changes nothing ("no new information").
 * Non-finite rays are ignored.
 *  @see [Paper Sec. III-B] */
class Mapper
{
 public:
  explicit Mapper(const MapperConfig& config);
  ~Mapper();
  Mapper(Mapper&&) noexcept;
  Mapper& operator=(Mapper&&) noexcept;

  /** Fuses the rays of one scan taken at time t [s] with the vehicle at p_L and makes a new
   * snapshot. The result does not depend on the number of threads. */
  MapUpdate integrate(double t, const Eigen::Vector3d& p_L, std::span<const core::Ray> rays)
  {
    return integrate(t, p_L, rays, MoverMask{});
  }

  /// The same with movers kept out: ghosts are cleared first, also by an empty scan.
  MapUpdate integrate(double t, const Eigen::Vector3d& p_L, std::span<const core::Ray> rays,
                      const MoverMask& movers);

  /// Newest snapshot; nullptr before the first integrate().
  [[nodiscard]] std::shared_ptr<const EdtSnapshot> snapshot() const;

  /// Forgets everything.
  void reset();

  /// Writes the octree of record as .bt (atomically). False if keep_octree is off or the file
  /// cannot be written.
  [[nodiscard]] bool writeOctree(const std::filesystem::path& file) const;

  [[nodiscard]] std::size_t memoryBytes() const;  ///< of window and octree

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace slalom::mapping
