// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>

#include "Lattice.h"

namespace slalom::search::detail
{
void Lattice::addWall(int wall, const Eigen::Vector3d& at_L, const Eigen::Vector3d& normal,
                      double sight_m, const Eigen::Vector3d& goal_L, double most_m)
{
  Eigen::Vector3d n = normal.normalized();
  // Upright, unless the path is steep: an inclined wall is in no column whole.
  if (std::abs(n.z()) < 0.7) n = Eigen::Vector3d(n.x(), n.y(), 0.0).normalized();
  // As thick as it takes to leave no hole for a diagonal step.
  const double half = 0.5 * resolution_ * n.lpNorm<1>() + 1e-9;
  const auto bit = static_cast<Walls>(1u << wall);
  std::vector<std::uint32_t>& seen = work_.flood;
  const auto visit = [&](const Eigen::Vector3i& at)
  {
    const std::uint32_t index = indexOf(at);
    Cell& cell = work_.cells[index];
    if (cell.stamp >= seen_stamp_ && (cell.flags & Flooded)) return;
    const Eigen::Vector3d p = place(at);
    if (std::abs(n.dot(p - at_L)) > half || !inside(at)) return;
    if ((p - start_L_).norm() + (p - goal_L).norm() > most_m) return;
    if (look(index, at).distance < sight_m) return;
    cell.flags |= Flooded;
    seen.push_back(index);
    if (sees(at_L, p, sight_m)) cell.walls |= bit;
  };
  seen.clear();
  const Eigen::Vector3i centre = nearestPoint(at_L);
  visit(centre);
  for (const Move& move : moves_) visit(centre + move.step);
  // So thick a plane hangs together by the faces of its cells.
  for (std::size_t i = 0; i < seen.size(); ++i)
  {
    if (!(work_.cells[seen[i]].walls & bit)) continue;
    const Eigen::Vector3i at = coordinates(seen[i]);
    for (int axis = 0; axis < 3; ++axis)
      for (const int sign : {-1, 1}) visit(at + sign * Eigen::Vector3i::Unit(axis));
  }
  for (const std::uint32_t index : seen)
  {
    work_.cells[index].flags &= static_cast<std::uint8_t>(~Flooded);
    if (work_.cells[index].walls & bit)
      closeColumn(columnOf(coordinates(index)), bit, goal_L, most_m);
  }
  seen.clear();
}

/// For the bound, if the wall leaves no point of the column open that is not too far away.
void Lattice::closeColumn(std::uint32_t column, Walls wall, const Eigen::Vector3d& goal_L,
                          double most_m)
{
  if (columns_->isClosed(column, wall)) return;
  Eigen::Vector3i at = coordinates(column);
  for (int layer = 1; layer < size_.z() - 1; ++layer)
  {
    ++at.z();
    const Eigen::Vector3d p = place(at);
    if ((p - start_L_).norm() + (p - goal_L).norm() > most_m) continue;
    const Cell& cell = look(indexOf(at), at);
    if (open(cell) && !(cell.walls & wall)) return;
  }
  columns_->close(column, wall);
}

bool Lattice::crosses(Walls walls, const Eigen::Vector3d& a_L, const Eigen::Vector3d& b_L) const
{
  if (walls == 0) return false;
  // So dense that the points nearest to the samples are neighbours: a wall has no hole for those.
  const int steps = static_cast<int>(2.0 * (b_L - a_L).norm() / resolution_) + 1;
  for (int i = 0; i <= steps; ++i)
  {
    const Eigen::Vector3i at = nearestPoint(a_L + (b_L - a_L) * (static_cast<double>(i) / steps));
    const Cell& cell = work_.cells[indexOf(at)];
    if (cell.stamp >= seen_stamp_ && (cell.walls & walls)) return true;
  }
  return false;
}

/// By the distances of the points along the way, of which no obstacle of a voxel's size is clear.
bool Lattice::sees(const Eigen::Vector3d& from_L, const Eigen::Vector3d& to_L, double sight_m)
{
  const Eigen::Vector3d way = to_L - from_L;
  const int steps = static_cast<int>(way.norm() / resolution_);
  for (int i = 1; i < steps; ++i)
  {
    const Eigen::Vector3i at = nearestPoint(to_L - way * (static_cast<double>(i) / steps));
    if (look(indexOf(at), at).distance < sight_m) return false;
  }
  return true;
}
}  // namespace slalom::search::detail
