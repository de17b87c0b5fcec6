// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "DistanceTransform.h"
#include "slalom/mapping/EdtSnapshot.h"

namespace slalom::mapping
{
namespace detail
{
/// The arrays of a snapshot, laid out by GridShape.
struct EdtCells
{
  std::vector<std::uint8_t> occupancy;    ///< core::Occupancy
  std::vector<std::int16_t> optimistic;   ///< [voxel^2] signed, unknown is free
  std::vector<std::int16_t> pessimistic;  ///< [voxel^2] signed, unknown is an obstacle

  void resize(const GridShape& shape);
};

/// Smallest squared cell distance [voxel^2] at which a distance counts as saturated: the obstacle
/// surface is then at least max_distance [m] away.
[[nodiscard]] int saturationCells(double max_distance, double resolution);

}  // namespace detail

struct EdtSnapshot::Grid
{
  detail::GridShape shape;
  Eigen::Vector3d origin_L = Eigen::Vector3d::Zero();  ///< [m] lower corner of cell (0,0,0)
  double resolution = 0.0;                             ///< [m]
  double max_distance = 0.0;                           ///< [m]
  double stamp = 0.0;                                  ///< [s]
  std::uint64_t sequence = 0;
  std::shared_ptr<const detail::EdtCells> cells;
  /// [m] distance to the obstacle surface of a squared cell distance; shared by all snapshots.
  std::shared_ptr<const std::vector<double>> metres;

  [[nodiscard]] static std::shared_ptr<const std::vector<double>> metresTable(double max_distance,
                                                                              double resolution);
};

}  // namespace slalom::mapping
