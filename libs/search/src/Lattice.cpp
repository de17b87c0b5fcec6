// SPDX-License-Identifier: BSD-3-Clause
#include "Lattice.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace slalom::search::detail
{
namespace
{
constexpr std::int64_t kMostCells = std::int64_t{1} << 26;
/// Greed of the search: the cost found is at most this times the smallest. Lengths are held tight;
/// where preference makes the cost a matter of taste, a greedier search sees far fewer points.
constexpr double kGreedForLength = 1.05, kGreedForPreference = 1.2;

/// Shortest way between two points on an empty lattice.
double latticeDistance(const Eigen::Vector3d& offset)
{
  const double x = std::abs(offset.x()), y = std::abs(offset.y()), z = std::abs(offset.z());
  const double most = std::max({x, y, z}), least = std::min({x, y, z});
  const double middle = x + y + z - most - least;
  constexpr double kSqrt2 = 1.4142135623730951, kSqrt3 = 1.7320508075688772;
  return (kSqrt3 - kSqrt2) * least + (kSqrt2 - 1.0) * middle + most;
}
}  // namespace

Lattice::Lattice(const core::DistanceField& field, const Eigen::Vector3d& start_L,
                 const Eigen::AlignedBox3d& region_L, const GridSearchConfig& config,
                 EdgeCheck edges)
    : field_(field),
      config_(config),
      start_L_(start_L),
      resolution_(field.resolution()),
      greed_(config.proximity_weight > 0.0 ? kGreedForPreference : kGreedForLength)
{
  const Eigen::Array3d low = ((region_L.min() - start_L) / resolution_).array();
  const Eigen::Array3d high = ((region_L.max() - start_L) / resolution_).array();
  const Eigen::Array3d count = (high + 1e-9).floor() - (low - 1e-9).ceil() + 1.0;
  if (!(count > 0.0).all() || !(count.prod() < static_cast<double>(kMostCells))) return;
  low_ = (low - 1e-9).ceil().cast<int>();
  size_ = count.cast<int>();
  goal_node_ = static_cast<std::uint32_t>(count.prod());
  // Fresh zero pages from the system: a search pays only for the cells that it touches.
  cells_.reset(static_cast<Cell*>(std::calloc(goal_node_ + 1, sizeof(Cell))));
  makeMoves(config.clearance_m, edges);
}

void Lattice::makeMoves(double clearance, EdgeCheck edges)
{
  for (int dz = -1; dz <= 1; ++dz)
    for (int dy = -1; dy <= 1; ++dy)
      for (int dx = -1; dx <= 1; ++dx)
      {
        const Eigen::Vector3i step(dx, dy, dz);
        if (step.isZero()) continue;
        const double length = resolution_ * step.cast<double>().norm();
        // An obstacle at distance D from an edge is within sqrt(D^2 + length^2 / 4) of one end.
        // Interpolation bends that; its slope is at most sqrt(3).
        const double sure = edges == EdgeCheck::Euclidean
                                ? std::hypot(clearance, 0.5 * length)
                                : clearance + 0.5 * std::sqrt(3.0) * length;
        const std::int64_t offset = dx + static_cast<std::int64_t>(size_.x()) *
                                             (dy + static_cast<std::int64_t>(size_.y()) * dz);
        moves_.push_back({step, offset, static_cast<float>(length), static_cast<float>(sure)});
      }
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
  return static_cast<std::uint32_t>(i.x() +
                                    static_cast<std::int64_t>(size_.x()) *
                                        (i.y() + static_cast<std::int64_t>(size_.y()) * i.z()));
}

bool Lattice::inside(const Eigen::Vector3i& at) const
{
  const Eigen::Array3i i = (at - low_).array();
  return (i >= 0).all() && (i < size_.array()).all();
}

Eigen::Vector3d Lattice::place(const Eigen::Vector3i& at) const
{
  return start_L_ + resolution_ * at.cast<double>();
}

Lattice::State Lattice::look(std::uint32_t index, const Eigen::Vector3i& at)
{
  Cell& cell = cells_[index];
  if (cell.state != Unseen) return cell.state;
  const auto distance = field_.distance(place(at), core::UnknownAs::Free);
  const bool open = distance && *distance >= config_.clearance_m;
  cell.distance = open ? static_cast<float>(*distance) : 0.0f;
  cell.cost = std::numeric_limits<float>::infinity();
  return cell.state = open ? Open : Blocked;
}

void Lattice::push(std::uint32_t cell, double priority)
{
  heap_.push_back({static_cast<float>(priority), pushed_++, cell});
  std::push_heap(heap_.begin(), heap_.end());
}

void Lattice::joinGoal(std::uint32_t from, const Eigen::Vector3d& from_L,
                       const Eigen::Vector3d& goal_L)
{
  const double length = (goal_L - from_L).norm();
  Cell& goal = cells_[goal_node_];
  const double factor =
      0.5 * (costPerMetre(cells_[from].distance, config_) + costPerMetre(goal.distance, config_));
  const auto cost = static_cast<float>(cells_[from].cost + length * factor);
  if (cost >= goal.cost || !segmentClear(field_, from_L, goal_L, config_.clearance_m)) return;
  goal.cost = cost;
  goal.parent = from;
  push(goal_node_, cost);
}

void Lattice::expand(std::uint32_t index, const Eigen::Vector3d& goal_L)
{
  const Cell& here = cells_[index];
  const Eigen::Vector3i at = coordinates(index);
  const Eigen::Vector3d here_L = place(at);
  const double here_factor = costPerMetre(here.distance, config_);
  if ((goal_L - here_L).cwiseAbs().maxCoeff() <= 1.001 * resolution_)
    joinGoal(index, here_L, goal_L);

  const Eigen::Vector3i local = at - low_;
  const bool interior = (local.array() > 0).all() && (local.array() + 1 < size_.array()).all();
  for (const Move& move : moves_)
  {
    const Eigen::Vector3i next = at + move.step;
    if (!interior && !inside(next)) continue;
    const auto neighbour = static_cast<std::uint32_t>(index + move.offset);
    if (look(neighbour, next) != Open) continue;
    Cell& there = cells_[neighbour];
    const double factor = 0.5 * (here_factor + costPerMetre(there.distance, config_));
    const auto cost = static_cast<float>(here.cost + move.length * factor);
    if (cost >= there.cost) continue;
    const Eigen::Vector3d next_L = place(next);
    if (std::min(here.distance, there.distance) < move.sure_distance &&
        !segmentClear(field_, here_L, next_L, config_.clearance_m))
      continue;
    there.cost = cost;
    there.parent = index;
    push(neighbour, cost + greed_ * latticeDistance(goal_L - next_L));
  }
}

std::optional<std::vector<Eigen::Vector3d>> Lattice::search(const Eigen::Vector3d& goal_L)
{
  const std::uint32_t start = indexOf(Eigen::Vector3i::Zero());
  if (look(start, Eigen::Vector3i::Zero()) != Open) return std::nullopt;
  cells_[start].cost = 0.0f;
  cells_[start].parent = start;
  const auto goal_distance = field_.distance(goal_L, core::UnknownAs::Free);
  cells_[goal_node_] = {std::numeric_limits<float>::infinity(),
                        static_cast<float>(goal_distance.value_or(0.0)), goal_node_, Open};
  push(start, 0.0);
  while (!heap_.empty())
  {
    const std::uint32_t index = heap_.front().cell;
    std::pop_heap(heap_.begin(), heap_.end());
    heap_.pop_back();
    if (index == goal_node_)
    {
      std::vector<Eigen::Vector3d> path = {goal_L};
      for (std::uint32_t at = cells_[index].parent; at != start; at = cells_[at].parent)
        path.push_back(place(coordinates(at)));
      path.push_back(start_L_);
      std::reverse(path.begin(), path.end());
      return path;
    }
    if (cells_[index].state == Expanded) continue;
    if (expansions_ >= config_.max_expansions)
    {
      limited_ = true;
      return std::nullopt;
    }
    ++expansions_;
    cells_[index].state = Expanded;
    expanded_.push_back(index);
    expand(index, goal_L);
  }
  return std::nullopt;
}

Eigen::Vector3d Lattice::nearestExpanded(const Eigen::Vector3d& place_L) const
{
  Eigen::Vector3d nearest = start_L_;
  double best = (start_L_ - place_L).squaredNorm();
  for (const std::uint32_t index : expanded_)
  {
    const Eigen::Vector3d p = place(coordinates(index));
    const double d = (p - place_L).squaredNorm();
    if (d >= best) continue;
    best = d;
    nearest = p;
  }
  return nearest;
}

std::optional<Eigen::Vector3d> Lattice::nearestOpen(const Eigen::Vector3d& place_L)
{
  // Cubic shells around the point that is nearest to the place. A point of shell s is at least
  // (s - 1/2) resolution away from it, hence from the place.
  const Eigen::Array3d offset = ((place_L - start_L_) / resolution_).array().round();
  const Eigen::Array3d low = low_.cast<double>().array();
  const Eigen::Vector3i centre =
      offset.max(low).min(low + size_.cast<double>().array() - 1.0).matrix().cast<int>();
  std::optional<Eigen::Vector3d> nearest;
  double best = std::numeric_limits<double>::infinity();
  for (int shell = 0; shell < size_.maxCoeff() && (shell - 0.5) * resolution_ < best; ++shell)
    for (int z = -shell; z <= shell; ++z)
      for (int y = -shell; y <= shell; ++y)
      {
        const bool face = std::abs(z) == shell || std::abs(y) == shell;
        for (int x = -shell; x <= shell; x += face || shell == 0 ? 1 : 2 * shell)
        {
          const Eigen::Vector3i at = centre + Eigen::Vector3i(x, y, z);
          if (!inside(at)) continue;
          const Eigen::Vector3d p = place(at);
          const double d = (p - place_L).norm();
          if (d >= best || look(indexOf(at), at) != Open) continue;
          best = d;
          nearest = p;
        }
      }
  return nearest;
}

}  // namespace slalom::search::detail
