// SPDX-License-Identifier: BSD-3-Clause
#include "PathFinder.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "Shortcut.h"

namespace slalom::search::detail
{
namespace
{
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
  notNegative(config.max_detour, "max_detour");
  notNegative(config.unknown_weight, "unknown_weight");
  if (config.unknown_weight > config.proximity_weight)
    throw std::invalid_argument(
        "GridSearchConfig: unknown_weight = " + std::to_string(config.unknown_weight) +
        ", must not be above proximity_weight = " + std::to_string(config.proximity_weight));
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
  if (!segmentClear(field, a, b, worth)) return false;
  if (config.unknown_weight == 0.0) return true;
  const double count = std::ceil((b - a).norm() / field.resolution());
  for (double i = 0.0; i <= count; i += 1.0)
    if (field.occupancy(a + (b - a) * (i / std::max(count, 1.0))) == core::Occupancy::Unknown)
      return false;
  return true;
}

bool clear(const core::DistanceField& field, const Path& path, double clearance)
{
  for (std::size_t i = 1; i < path.size(); ++i)
    if (!segmentClear(field, path[i - 1], path[i], clearance)) return false;
  return true;
}

void finish(SearchResult& result, const PricedPath& path)
{
  result.status = SearchStatus::Found;
  result.cost_m = path.cost;
  result.path.resize(3, static_cast<Eigen::Index>(path.points.size()));
  for (std::size_t i = 0; i < path.points.size(); ++i)
  {
    result.path.col(static_cast<Eigen::Index>(i)) = path.points[i];
    if (i > 0) result.length_m += (path.points[i] - path.points[i - 1]).norm();
  }
  result.nearest_L = path.points.back();
}
}  // namespace

PathFinder::PathFinder(const core::DistanceField& field, const Eigen::Vector3d& start_L,
                       const Eigen::Vector3d& goal_L, const Eigen::AlignedBox3d& box_L,
                       const GridSearchConfig& config)
    : field_(field),
      config_(config),
      start_L_(start_L),
      goal_L_(goal_L),
      region_L_(box_L.intersection(field.bounds()))
{
  check(config);
}

Lattice* PathFinder::lattice()
{
  if (!lattice_) lattice_.emplace(field_, start_L_, region_L_, config_);
  return lattice_->usable() ? &*lattice_ : nullptr;
}

std::optional<SearchStatus> PathFinder::blockedEnd(SearchResult& result)
{
  if (!region_L_.contains(start_L_) || !keepsClearance(field_, start_L_, config_.clearance_m))
    return SearchStatus::StartBlocked;
  if (region_L_.contains(goal_L_) && keepsClearance(field_, goal_L_, config_.clearance_m))
    return std::nullopt;
  if (goal_L_.allFinite() && lattice())
  {
    result.nearest_L = lattice_->nearestReachable(goal_L_, std::nullopt);
    result.expansions = lattice_->expansions();
  }
  return SearchStatus::GoalBlocked;
}

SearchResult PathFinder::first()
{
  SearchResult result;
  result.nearest_L = start_L_;
  if (const auto blocked = blockedEnd(result))
    result.status = *blocked;
  else if (straightIsBest(field_, start_L_, goal_L_, config_))
    finish(result, {{start_L_, goal_L_}, (goal_L_ - start_L_).norm()});
  else if (lattice())
  {
    Lattice::Query query;
    query.goal_L = goal_L_;
    searchOn(*lattice_, query, result);
  }
  else
    result.status = SearchStatus::ExpansionLimit;
  return result;
}

SearchResult PathFinder::around(Walls walls, double most_cost, int most_expansions)
{
  SearchResult result;
  result.nearest_L = start_L_;
  if (!lattice()) return result;
  Lattice::Query query;
  query.goal_L = goal_L_;
  query.walls = walls;
  query.most_cost = most_cost;
  query.most_expansions = most_expansions;
  searchOn(*lattice_, query, result);
  return result;
}

void PathFinder::searchOn(Lattice& lattice, Lattice::Query query, SearchResult& result)
{
  // Distances of a real field are interpolated, so what is quick to check is checked again on the
  // result, and the rare failure is searched again the slow way.
  const int before = lattice.expansions();
  for (const auto edges : {EdgeCheck::Euclidean, EdgeCheck::Marched})
  {
    query.edges = edges;
    const SearchEnd end = lattice.search(query);
    result.expansions = lattice.expansions() - before;
    if (end != SearchEnd::Found)
    {
      result.status =
          end == SearchEnd::Limit ? SearchStatus::ExpansionLimit : SearchStatus::Unreachable;
      if (query.walls == 0) result.nearest_L = lattice.nearestReachable(goal_L_, end);
      return;
    }
    const PricedPath path = shortcut(field_, lattice.path(), config_, lattice, query.walls);
    if (edges == EdgeCheck::Euclidean && !clear(field_, path.points, config_.clearance_m)) continue;
    finish(result, path);
    return;
  }
}

}  // namespace slalom::search::detail
