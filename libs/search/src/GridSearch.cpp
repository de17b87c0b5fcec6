// SPDX-License-Identifier: BSD-3-Clause
#include "slalom/search/GridSearch.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "Lattice.h"
#include "Shortcut.h"

namespace slalom::search
{
namespace
{
using Path = std::vector<Eigen::Vector3d>;

void check(const GridSearchConfig& config)
{
  const auto notNegative = [](double value, const char* name)
  {
    if (!(value >= 0.0) || !std::isfinite(value))
      throw std::invalid_argument(std::string("GridSearchConfig: ") + name + " = " +
                                  std::to_string(value) + ", must be >= 0 and finite");
  };
  notNegative(config.clearance_m, "clearance_m");
  notNegative(config.preferred_clearance_m, "preferred_clearance_m");
  notNegative(config.proximity_weight, "proximity_weight");
}

bool keepsClearance(const core::DistanceField& field, const Eigen::Vector3d& p, double clearance)
{
  const auto distance = field.distance(p, core::UnknownAs::Free);
  return distance && *distance >= clearance;
}

/// No path can be cheaper than a straight one with all the clearance that is worth paying for.
bool straightIsBest(const core::DistanceField& field, const Eigen::Vector3d& a,
                    const Eigen::Vector3d& b, const GridSearchConfig& config)
{
  const double worth = config.proximity_weight > 0.0
                           ? std::max(config.clearance_m, config.preferred_clearance_m)
                           : config.clearance_m;
  return segmentClear(field, a, b, worth);
}

bool clear(const core::DistanceField& field, const Path& path, double clearance)
{
  for (std::size_t i = 1; i < path.size(); ++i)
    if (!segmentClear(field, path[i - 1], path[i], clearance)) return false;
  return true;
}

void finish(SearchResult& result, const Path& path)
{
  result.status = SearchStatus::Found;
  result.path.resize(3, static_cast<Eigen::Index>(path.size()));
  for (std::size_t i = 0; i < path.size(); ++i)
  {
    result.path.col(static_cast<Eigen::Index>(i)) = path[i];
    if (i > 0) result.length_m += (path[i] - path[i - 1]).norm();
  }
  result.nearest_L = path.back();
}

/// The goal is in an obstacle: how near can one come? If the open point nearest to the goal can be
/// reached, that is the answer; else the search has seen all that can be reached.
void approach(const core::DistanceField& field, const Eigen::Vector3d& start_L,
              const Eigen::Vector3d& goal_L, const Eigen::AlignedBox3d& region_L,
              const GridSearchConfig& config, SearchResult& result)
{
  detail::Lattice lattice(field, start_L, region_L, config, detail::EdgeCheck::Marched);
  if (!lattice.usable()) return;
  const auto target = lattice.nearestOpen(goal_L);
  if (!target) return;
  const auto path = lattice.search(*target);
  result.expansions = lattice.expansions();
  result.nearest_L = path ? *target : lattice.nearestExpanded(goal_L);
}
}  // namespace

SearchResult findPath(const core::DistanceField& field, const Eigen::Vector3d& start_L,
                      const Eigen::Vector3d& goal_L, const Eigen::AlignedBox3d& box_L,
                      const GridSearchConfig& config)
{
  check(config);
  SearchResult result;
  result.nearest_L = start_L;
  const Eigen::AlignedBox3d region = box_L.intersection(field.bounds());
  if (!region.contains(start_L) || !keepsClearance(field, start_L, config.clearance_m))
  {
    result.status = SearchStatus::StartBlocked;
    return result;
  }
  if (!region.contains(goal_L) || !keepsClearance(field, goal_L, config.clearance_m))
  {
    result.status = SearchStatus::GoalBlocked;
    if (goal_L.allFinite()) approach(field, start_L, goal_L, region, config, result);
    return result;
  }
  if (straightIsBest(field, start_L, goal_L, config))
  {
    finish(result, {start_L, goal_L});
    return result;
  }
  // Distances of a real field are interpolated, so what is quick to check is checked again on the
  // result, and the rare failure is searched again the slow way.
  for (const auto edges : {detail::EdgeCheck::Euclidean, detail::EdgeCheck::Marched})
  {
    detail::Lattice lattice(field, start_L, region, config, edges);
    if (!lattice.usable())
    {
      result.status = SearchStatus::ExpansionLimit;
      return result;
    }
    const auto path = lattice.search(goal_L);
    result.expansions += lattice.expansions();
    if (!path)
    {
      result.status = lattice.limited() ? SearchStatus::ExpansionLimit : SearchStatus::Unreachable;
      result.nearest_L = lattice.nearestExpanded(goal_L);
      return result;
    }
    if (edges == detail::EdgeCheck::Euclidean && !clear(field, *path, config.clearance_m)) continue;
    finish(result, detail::shortcut(field, *path, config));
    break;
  }
  return result;
}

bool segmentClear(const core::DistanceField& field, const Eigen::Vector3d& a_L,
                  const Eigen::Vector3d& b_L, double clearance_m)
{
  constexpr double kFinest = 1e-3;  // [m] least step; a dip between two steps is half as deep
  const double length = (b_L - a_L).norm();
  if (!std::isfinite(length)) return false;
  const Eigen::Vector3d direction = length > 0.0 ? ((b_L - a_L) / length).eval() : b_L - a_L;
  for (double at = 0.0;;)
  {
    const auto distance =
        field.distance(at < length ? (a_L + at * direction).eval() : b_L, core::UnknownAs::Free);
    if (!distance || !(*distance >= clearance_m)) return false;
    if (at >= length) return true;
    at = std::min(length, at + std::max(kFinest, *distance - clearance_m));
  }
}

}  // namespace slalom::search
