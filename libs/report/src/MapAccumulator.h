// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <utility>

#include "FieldSlice.h"
#include "slalom/core/DistanceField.h"

namespace slalom::report::detail
{
/** The map of the whole flight as seen from above: what the fields said, when they were last asked,
 * of a band of one voxel above and below the altitude flown there. Occupied anywhere in the band
 * makes a cell occupied. Bounded: at most kMaxTiles tiles; beyond that new ground is not recorded.
 */
class MapAccumulator
{
 public:
  static constexpr int kTile = 64;  ///< cells per side
  static constexpr std::size_t kMaxTiles = 4096;

  /// Asks the field when the vehicle has moved or time has passed since the last time.
  void add(const std::shared_ptr<const core::DistanceField>& field, double t,
           const Eigen::Vector3d& p_L);
  /// Asks the newest field, for the end of a flight.
  void finish();

  /// Cells inside the box, row 0 the lowest y; `Outside` where nothing was ever known.
  [[nodiscard]] FieldSlice cells(const Eigen::Vector2d& lo, const Eigen::Vector2d& hi) const;
  [[nodiscard]] bool empty() const { return tiles_.empty(); }
  [[nodiscard]] std::size_t memoryBytes() const { return tiles_.size() * sizeof(Tile); }

 private:
  using Tile = std::array<CellState, kTile * kTile>;
  using Key = std::pair<int, int>;
  void absorb(const core::DistanceField& field, double z);
  void set(int column, int row, CellState state);

  double cell_ = 0.0;  ///< [m] of the first field
  std::map<Key, Tile> tiles_;
  std::shared_ptr<const core::DistanceField> pending_;
  double last_t_ = 0.0;
  Eigen::Vector3d pending_p_L_ = Eigen::Vector3d::Zero(), last_p_L_ = Eigen::Vector3d::Zero();
  bool any_ = false;
};

}  // namespace slalom::report::detail
