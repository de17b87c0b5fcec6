// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "InstructionSet.h"

namespace slalom::mapping::detail
{
/// Rows of all grids start at multiples of this many cells, so that vectors need no tails.
inline constexpr int kLanes = 32;

/// Layout of a dense grid: x fastest, rows padded to kLanes cells.
struct GridShape
{
  Eigen::Vector3i size = Eigen::Vector3i::Zero();

  [[nodiscard]] int pitch() const { return (size.x() + kLanes - 1) / kLanes * kLanes; }
  [[nodiscard]] std::size_t row(int y, int z) const
  {
    return (static_cast<std::size_t>(z) * size.y() + y) * pitch();
  }
  [[nodiscard]] std::size_t cells() const { return row(0, size.z()); }
};

/** Exact Euclidean distance transform of a three-valued grid, signed, saturated, in integers.
 *
 *  For every cell the result is +d2 if the cell is no obstacle (d2 = squared distance, in voxels,
 * to the centre of the nearest obstacle cell) and -d2 if it is one (to the nearest cell that is
 * none); |d2| <= saturation. Everything outside the grid is unknown space in both fields: free in
 * the optimistic one, obstacle in the pessimistic one.
 *
 *  Separable: distances along y by two running counters, then along x and z the lower envelope
 * min_k f(i + k) + k^2, which is exact because squares add over the axes. Cost is O(cells * radius)
 * at worst; each vector of cells stops at the first k with k^2 >= its largest value. */
class DistanceTransform
{
 public:
  static constexpr int kMaxSaturation = 14000;  ///< d2 + k^2 must fit 16 bits

  /// @param saturation in 1..kMaxSaturation; throws std::invalid_argument otherwise
  DistanceTransform(const GridShape& shape, int saturation,
                    InstructionSet set = bestInstructionSet());

  /** @param occupancy core::Occupancy per cell, shape.cells() bytes; padding is ignored
   *  @param optimistic,pessimistic shape.cells() results; padding is unspecified */
  void run(const std::uint8_t* occupancy, std::int16_t* optimistic, std::int16_t* pessimistic);

 private:
  GridShape shape_;
  int saturation_;
  InstructionSet set_;
  int radius_;  ///< largest k that can improve a distance: k^2 < saturation
  int pad_;
  std::vector<std::int16_t> squares_;  ///< k^2, kLanes times each
  std::vector<std::int16_t> scratch_;
};

}  // namespace slalom::mapping::detail
