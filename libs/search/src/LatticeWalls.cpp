// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>

#include "Lattice.h"

namespace slalom::search::detail
{
void Lattice::addWall(int wall, const Eigen::Vector3d& at_L, const Eigen::Vector3d& normal,
                      double sight_m, const Eigen::Vector3d& goal_L, double most_m)
{
  const Eigen::Vector3d n = normal.normalized();
  // As thick as it takes to leave no hole for a diagonal step.
  const double half = 0.5 * resolution_ * n.lpNorm<1>() + 1e-9;
  const auto bit = static_cast<Walls>(1u << wall);
  std::vector<std::uint32_t>& seen = work_.flood;
  const auto visit = [&](const Eigen::Vector3i& at)
  {
    const Eigen::Vector3d p = place(at);
    if (std::abs(n.dot(p - at_L)) > half || !inside(at)) return;
    if ((p - start_L_).norm() + (p - goal_L).norm() > most_m) return;
    const std::uint32_t index = indexOf(at);
    Cell& cell = look(index, at);
    if ((cell.flags & Flooded) || cell.distance < sight_m) return;
    cell.flags |= Flooded;
    seen.push_back(index);
    if (sees(at_L, p, sight_m)) cell.walls |= bit;
  };
  seen.clear();
  const Eigen::Vector3i centre = nearestPoint(at_L);
  visit(centre);
  for (const Move& move : moves_) visit(centre + move.step);
  for (std::size_t i = 0; i < seen.size(); ++i)
  {
    if (!(work_.cells[seen[i]].walls & bit)) continue;
    const Eigen::Vector3i at = coordinates(seen[i]);
    for (const Move& move : moves_) visit(at + move.step);
  }
  for (const std::uint32_t index : seen)
    work_.cells[index].flags &= static_cast<std::uint8_t>(~Flooded);
  seen.clear();
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
