// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>

#include "Lattice.h"

namespace slalom::search::detail
{
void Lattice::startFlood(const Query& query)
{
  flood_state_ = Flood::Running;
  flood_next_ = 0;
  const Eigen::Vector3i centre = nearestPoint(query.goal_L);
  for (int dz = -2; dz <= 2; ++dz)
    for (int dy = -2; dy <= 2; ++dy)
      for (int dx = -2; dx <= 2; ++dx)
      {
        const Eigen::Vector3i at = centre + Eigen::Vector3i(dx, dy, dz);
        const Eigen::Array3f offset = goal_ - at.cast<float>().array();
        if (!inside(at) || offset.abs().maxCoeff() > 1.001f) continue;
        const std::uint32_t index = indexOf(at);
        Cell& cell = look(index, at);
        if (!open(cell) || (cell.walls & query.walls)) continue;
        cell.flags |= Flooded;
        work_.flood.push_back(index);
      }
}

/** Floods from the goal over all pairs of open neighbours, more edges than a search may use: what
 * has no such way to the start has none at all.
 *  @return true if there is nothing left to flood and the search was not met: it cannot succeed */
bool Lattice::floodUpTo(std::size_t count, Walls walls)
{
  if (flood_state_ != Flood::Running) return false;
  std::vector<std::uint32_t>& flood = work_.flood;
  for (; flood_next_ < flood.size() && flood_next_ < count; ++flood_next_)
  {
    const std::uint32_t index = flood[flood_next_];
    if (work_.cells[index].stamp == search_stamp_)
    {
      flood_state_ = Flood::MetTheSearch;
      return false;
    }
    const Eigen::Vector3i at = coordinates(index);
    for (const Move& move : moves_)
    {
      const auto next = static_cast<std::uint32_t>(static_cast<std::int32_t>(index) + move.offset);
      Cell& cell = look(next, at + move.step);
      if (!open(cell) || (cell.walls & walls) || (cell.flags & Flooded)) continue;
      cell.flags |= Flooded;
      flood.push_back(next);
    }
  }
  return flood_next_ == flood.size();
}

Eigen::Vector3d Lattice::nearestReachable(const Eigen::Vector3d& place_L,
                                          std::optional<SearchEnd> end)
{
  while (!end || *end == SearchEnd::GoalExhausted)
  {
    const auto target = nearestOpen(place_L);
    if (!target) return start_L_;
    Query query;
    query.goal_L = *target;
    query.edges = EdgeCheck::Marched;
    end = search(query);
    if (*end == SearchEnd::Found) return *target;
  }
  return nearestExpanded(place_L);
}

Eigen::Vector3d Lattice::nearestExpanded(const Eigen::Vector3d& place_L) const
{
  Eigen::Vector3d nearest = start_L_;
  double best = (start_L_ - place_L).squaredNorm();
  for (const std::uint32_t index : work_.expanded)
  {
    const Eigen::Vector3d p = place(coordinates(index));
    const double d = (p - place_L).squaredNorm();
    if (d >= best) continue;
    best = d;
    nearest = p;
  }
  return nearest;
}

/// Open point nearest to a place, unless it is known that it cannot be reached.
std::optional<Eigen::Vector3d> Lattice::nearestOpen(const Eigen::Vector3d& place_L)
{
  // Cubic shells around the point that is nearest to the place. A point of shell s is at least
  // (s - 1/2) resolution away from it, hence from the place.
  const Eigen::Vector3i centre = nearestPoint(place_L);
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
          if (d >= best || columns_->inPocket(columnOf(at))) continue;
          const Cell& cell = look(indexOf(at), at);
          if (!open(cell) || (cell.flags & Pocket)) continue;
          best = d;
          nearest = p;
        }
      }
  return nearest;
}

}  // namespace slalom::search::detail
