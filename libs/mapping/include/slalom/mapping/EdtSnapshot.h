// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "slalom/core/DistanceField.h"

namespace slalom::mapping
{
/** Exact Euclidean distance transform of one map window, frozen.
 *
 *  Cells hold integer squared distances (in voxels, centre to centre) to the nearest occupied cell,
 * once with unknown as free and once with unknown as occupied, and a signed part inside obstacles.
 * Metres are made on query: sample() interpolates the signed centre distances trilinearly and
 * subtracts half a voxel (obstacle surface); lowerBound() is the proved bound of
 * core::DistanceField, hullBound() goes back to the voxels' cubes. Immutable,
 * thread-safe. */
class EdtSnapshot final : public core::DistanceField
{
 public:
  struct Grid;  ///< dense arrays, made by Mapper or by fromOccupancy()

  explicit EdtSnapshot(std::shared_ptr<const Grid> grid);

  /** Snapshot of a given three-valued grid, x fastest.
   *  @param origin_L lower corner of cell (0,0,0) [m]
   *  @param cells nx*ny*nz values */
  [[nodiscard]] static std::shared_ptr<const EdtSnapshot> fromOccupancy(
      const Eigen::Vector3d& origin_L, const Eigen::Vector3i& size, double resolution,
      const std::vector<core::Occupancy>& cells, double max_distance, double stamp = 0.0);

  [[nodiscard]] core::Occupancy occupancy(const Eigen::Vector3d& p_L) const override;
  [[nodiscard]] std::optional<core::DistanceSample> sample(const Eigen::Vector3d& p_L,
                                                           core::UnknownAs unknown) const override;
  [[nodiscard]] std::optional<double> lowerBound(const Eigen::Vector3d& p_L,
                                                 core::UnknownAs unknown) const override;
  [[nodiscard]] double hullBound(const core::Hull4& hull_L, core::UnknownAs unknown,
                                 double limit) const override;
  void collectObstacles(const Eigen::AlignedBox3d& box_L, core::UnknownAs unknown,
                        std::vector<Eigen::Vector3d>& centres_L) const override;
  [[nodiscard]] Eigen::AlignedBox3d bounds() const override;
  [[nodiscard]] double resolution() const override;
  [[nodiscard]] double maxDistance() const override;
  [[nodiscard]] double stamp() const override;
  [[nodiscard]] std::uint64_t sequence() const override;

 private:
  std::shared_ptr<const Grid> grid_;
};

}  // namespace slalom::mapping
