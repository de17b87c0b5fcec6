// SPDX-License-Identifier: BSD-3-Clause
#include "Lattice.h"

#include <algorithm>
#include <cmath>

namespace slalom::search::detail
{
namespace
{
constexpr double kMostCells = 67108864.0;
/// A thread keeps its memory between searches up to this many cells (16 bytes each).
constexpr std::size_t kMostKept = std::size_t{1} << 22;
}  // namespace

Lattice::Workspace& Lattice::ofThisThread()
{
  thread_local Workspace workspace;
  return workspace;
}

Lattice::Lattice(const core::DistanceField& field, const Eigen::Vector3d& start_L,
                 const Eigen::AlignedBox3d& region_L, const GridSearchConfig& config)
    : field_(field),
      config_(config),
      start_L_(start_L),
      resolution_(field.resolution()),
      clearance_(static_cast<float>(config.clearance_m)),
      preferred_(static_cast<float>(config.preferred_clearance_m))
{
  const double span = config.preferred_clearance_m - config.clearance_m;
  slope_ = span > 0.0 ? static_cast<float>(config.proximity_weight / span) : 0.0f;
  const Eigen::Array3d low = (((region_L.min() - start_L) / resolution_).array() - 1e-9).ceil();
  const Eigen::Array3d high = (((region_L.max() - start_L) / resolution_).array() + 1e-9).floor();
  const Eigen::Array3d count = high - low + 3.0;
  if (!(count > 2.0).all() || !(count.prod() < kMostCells)) return;
  usable_ = true;
  low_ = low.cast<int>() - 1;
  size_ = count.cast<int>();
  std::swap(work_, ofThisThread());
  const auto cells = static_cast<std::size_t>(count.prod());
  if (work_.cells.size() < cells) work_.cells.resize(cells);
  if (work_.stamp > 0xffff0000u)
  {
    std::fill(work_.cells.begin(), work_.cells.end(), Cell{});
    work_.columns = {};
    work_.stamp = 0;
  }
  seen_stamp_ = ++work_.stamp;
  makeMoves();
  columns_.emplace(*this, work_.columns, size_, static_cast<float>(resolution_), seen_stamp_);
}

Lattice::~Lattice()
{
  if (usable_ && work_.cells.size() <= kMostKept) std::swap(work_, ofThisThread());
}

void Lattice::makeMoves()
{
  moves_.reserve(26);
  for (int dz = -1; dz <= 1; ++dz)
    for (int dy = -1; dy <= 1; ++dy)
      for (int dx = -1; dx <= 1; ++dx)
      {
        const Eigen::Vector3i step(dx, dy, dz);
        if (step.isZero()) continue;
        const double length = resolution_ * step.cast<double>().norm();
        moves_.push_back({step, dx + size_.x() * (dy + size_.y() * dz), dx + 1 + 3 * (dy + 1),
                          static_cast<float>(length), 0.0f});
      }
}

void Lattice::setEdgeCheck(EdgeCheck edges)
{
  // An obstacle at distance D from an edge is within sqrt(D^2 + length^2 / 4) of one end.
  // Interpolation bends that; its slope is at most sqrt(3).
  const float half_slope = 0.5f * std::sqrt(3.0f);
  for (Move& move : moves_)
    move.sure_distance = edges == EdgeCheck::Euclidean ? std::hypot(clearance_, 0.5f * move.length)
                                                       : clearance_ + half_slope * move.length;
}

Eigen::Vector3i Lattice::coordinates(std::uint32_t cell) const
{
  const auto nx = static_cast<std::uint32_t>(size_.x()), ny = static_cast<std::uint32_t>(size_.y());
  const std::uint32_t row = cell / nx;
  return low_ + Eigen::Vector3i(static_cast<int>(cell % nx), static_cast<int>(row % ny),
                                static_cast<int>(row / ny));
}

std::uint32_t Lattice::indexOf(const Eigen::Vector3i& at) const
{
  const Eigen::Vector3i i = at - low_;
  return static_cast<std::uint32_t>(i.x() + size_.x() * (i.y() + size_.y() * i.z()));
}

bool Lattice::inside(const Eigen::Vector3i& at) const
{
  const Eigen::Array3i i = (at - low_).array();
  return (i >= 1).all() && (i < size_.array() - 1).all();
}

Eigen::Vector3d Lattice::place(const Eigen::Vector3i& at) const
{
  return start_L_ + resolution_ * at.cast<double>();
}

Eigen::Vector3i Lattice::nearestPoint(const Eigen::Vector3d& place_L) const
{
  const Eigen::Array3d offset = ((place_L - start_L_) / resolution_).array().round();
  const Eigen::Array3d low = low_.cast<double>().array() + 1.0;
  return offset.max(low).min(low + size_.cast<double>().array() - 3.0).matrix().cast<int>();
}

Lattice::Cell& Lattice::look(std::uint32_t index, const Eigen::Vector3i& at)
{
  Cell& cell = work_.cells[index];
  if (cell.stamp < seen_stamp_) ask(cell, at);
  return cell;
}

void Lattice::ask(Cell& cell, const Eigen::Vector3i& at)
{
  auto distance = inside(at) ? field_.distance(place(at), core::UnknownAs::Free) : std::nullopt;
  if (distance) distance = pricedDistance(field_, place(at), *distance, config_);
  constexpr float kOutside = -std::numeric_limits<float>::infinity();
  cell.distance = distance ? static_cast<float>(*distance) : kOutside;
  // In doubles, so that a point is open exactly if it keeps the clearance.
  if (distance && !(*distance >= config_.clearance_m) && cell.distance >= clearance_)
    cell.distance = std::nextafter(clearance_, 0.0f);
  cell.stamp = seen_stamp_;
  cell.walls = 0;
  cell.flags = 0;
}

float Lattice::bestFactor(std::uint32_t column)
{
  // From the start's layer outwards: where obstacles are upright, the first look is enough.
  const Eigen::Vector3i at = coordinates(column);
  const int layers = size_.z() - 2, first = -low_.z() - 1;
  const auto layer_cells = static_cast<std::uint32_t>(size_.x() * size_.y());
  float best = -std::numeric_limits<float>::infinity();
  for (int i = 0; i < 2 * layers; ++i)
  {
    const int layer = first + (i % 2 == 0 ? i / 2 : -(i + 1) / 2);
    if (layer < 0 || layer >= layers) continue;
    const std::uint32_t index = column + layer_cells * static_cast<std::uint32_t>(layer + 1);
    best = std::max(best, look(index, {at.x(), at.y(), low_.z() + 1 + layer}).distance);
    if (best >= preferred_ && best >= clearance_) return 1.0f;
    if (i == 0 && !inside({at.x(), at.y(), low_.z() + 1 + layer})) break;
  }
  if (!(best >= clearance_)) return std::numeric_limits<float>::infinity();
  return 1.0f + slope_ * std::max(0.0f, preferred_ - best);
}

}  // namespace slalom::search::detail
