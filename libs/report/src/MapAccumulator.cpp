// SPDX-License-Identifier: BSD-3-Clause
#include "MapAccumulator.h"

#include <algorithm>
#include <cmath>

namespace slalom::report::detail
{
namespace
{
constexpr double kEveryMetres = 0.5, kEverySeconds = 1.0;
constexpr double kMaxHalfWidth = 25.0;  // [m] of the region read from one field
constexpr int kMaxCells = 2000;         // per side of a picture

int floorDiv(int a, int b)
{
  return a >= 0 ? a / b : -((b - 1 - a) / b);
}
}  // namespace

void MapAccumulator::add(const std::shared_ptr<const core::DistanceField>& field, double t,
                         const Eigen::Vector3d& p_L)
{
  if (!field || !p_L.allFinite()) return;
  pending_ = field;
  pending_p_L_ = p_L;
  if (any_ && t - last_t_ < kEverySeconds && (p_L - last_p_L_).norm() < kEveryMetres) return;
  any_ = true;
  last_t_ = t;
  last_p_L_ = p_L;
  finish();
}

void MapAccumulator::finish()
{
  if (pending_) absorb(*pending_, pending_p_L_.z());
  pending_.reset();
}

void MapAccumulator::absorb(const core::DistanceField& field, double z)
{
  if (cell_ <= 0.0) cell_ = field.resolution();
  const Eigen::AlignedBox3d bounds = field.bounds();
  const Eigen::Vector2d here = pending_p_L_.head<2>();
  const Eigen::Vector2d lo =
      bounds.min().head<2>().cwiseMax(here - Eigen::Vector2d::Constant(kMaxHalfWidth));
  const Eigen::Vector2d hi =
      bounds.max().head<2>().cwiseMin(here + Eigen::Vector2d::Constant(kMaxHalfWidth));
  const Eigen::Vector2i first = (lo / cell_).array().ceil().cast<int>();
  const Eigen::Vector2i last = (hi / cell_).array().floor().cast<int>();
  for (int row = first.y(); row < last.y(); ++row)
    for (int column = first.x(); column < last.x(); ++column)
    {
      CellState state = CellState::Outside;
      for (const double dz : {-cell_, 0.0, cell_})
      {
        const auto seen = field.occupancy({(column + 0.5) * cell_, (row + 0.5) * cell_, z + dz});
        if (seen == core::Occupancy::Occupied) state = CellState::Occupied;
        if (seen == core::Occupancy::Free && state == CellState::Outside) state = CellState::Free;
      }
      if (state != CellState::Outside) set(column, row, state);
    }
}

void MapAccumulator::set(int column, int row, CellState state)
{
  const Key key(floorDiv(column, kTile), floorDiv(row, kTile));
  auto tile = tiles_.find(key);
  if (tile == tiles_.end())
  {
    if (tiles_.size() >= kMaxTiles) return;
    tile = tiles_.emplace(key, Tile{}).first;
  }
  const int index = (row - key.second * kTile) * kTile + (column - key.first * kTile);
  tile->second[static_cast<std::size_t>(index)] = state;
}

FieldSlice MapAccumulator::cells(const Eigen::Vector2d& lo, const Eigen::Vector2d& hi) const
{
  FieldSlice picture;
  if (cell_ <= 0.0) return picture;
  const Eigen::Vector2i first = (lo / cell_).array().floor().cast<int>();
  const Eigen::Vector2i count = ((hi / cell_).array().ceil().cast<int>() - first.array()) + 1;
  const int skip = std::max(1, (count.maxCoeff() + kMaxCells - 1) / kMaxCells);
  picture.cell = cell_ * skip;
  picture.origin_L = first.cast<double>() * cell_;
  picture.state =
      cv::Mat((count.y() + skip - 1) / skip, (count.x() + skip - 1) / skip, CV_8U, cv::Scalar(0));
  for (const auto& [key, tile] : tiles_)
    for (int i = 0; i < kTile * kTile; ++i)
    {
      const int column = (key.first * kTile + i % kTile - first.x());
      const int row = (key.second * kTile + i / kTile - first.y());
      if (column < 0 || row < 0) continue;
      const cv::Point at(column / skip, row / skip);
      if (at.x >= picture.state.cols || at.y >= picture.state.rows) continue;
      // Where cells share a pixel an obstacle wins.
      auto& out = picture.state.at<std::uint8_t>(at);
      out = std::max(out, static_cast<std::uint8_t>(tile[static_cast<std::size_t>(i)]));
    }
  return picture;
}

}  // namespace slalom::report::detail
