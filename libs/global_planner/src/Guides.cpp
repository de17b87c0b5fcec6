// SPDX-License-Identifier: BSD-3-Clause
#include "slalom/global_planner/Guides.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <optional>

#include "slalom/global_planner/Retreat.h"
#include "slalom/search/DistinctPaths.h"

namespace slalom::global_planner
{
namespace
{
using Eigen::Vector3d;

std::string reasonFor(search::SearchStatus status)
{
  switch (status)
  {
    case search::SearchStatus::Found:
      return {};
    case search::SearchStatus::StartBlocked:
      return "guide: start blocked";
    case search::SearchStatus::GoalBlocked:
      return "guide: goal blocked";
    case search::SearchStatus::Unreachable:
      return "guide: no way around";
    case search::SearchStatus::ExpansionLimit:
      return "guide: search limit";
  }
  return "guide";
}

/// The place itself if it is clear, else where it is left for; a blocked place stays what it is.
Vector3d clearOf(const core::DistanceField& field, const Vector3d& place_L, double hard_clearance)
{
  constexpr double kRetreat_m = 1.0;
  // Where the distance is interpolated, exactly the clearance here may be a little less there.
  constexpr double kBitMore = 1.02;
  const auto here = field.distance(place_L, core::UnknownAs::Free);
  if (!here || *here >= hard_clearance) return place_L;
  return findRetreat(field, place_L, kBitMore * hard_clearance, kRetreat_m).value_or(place_L);
}

/// The way with its legs out of and into hard clearance.
Eigen::Matrix3Xd withLegs(const Vector3d& start_L, const Eigen::Matrix3Xd& way,
                          const Vector3d& goal_L)
{
  const Eigen::Index before = way.col(0) == start_L ? 0 : 1;
  const Eigen::Index behind = way.col(way.cols() - 1) == goal_L ? 0 : 1;
  Eigen::Matrix3Xd all(3, before + way.cols() + behind);
  all.middleCols(before, way.cols()) = way;
  if (before > 0) all.col(0) = start_L;
  if (behind > 0) all.col(all.cols() - 1) = goal_L;
  return all;
}

}  // namespace

GuideSearch searchGuides(const core::DistanceField& field, const Vector3d& start_L,
                         const Vector3d& goal_L, double hard_clearance, int count,
                         const GlobalPlannerConfig& config)
{
  search::GridSearchConfig search_config;
  search_config.clearance_m = hard_clearance;
  search_config.preferred_clearance_m = std::max(config.clearance_m, hard_clearance);
  search_config.proximity_weight = config.guide_proximity_weight;
  search_config.unknown_weight =
      std::min(config.guide_unknown_weight, config.guide_proximity_weight);
  const Vector3d start = clearOf(field, start_L, hard_clearance);
  const Vector3d goal = clearOf(field, goal_L, hard_clearance);
  const double reach = std::max(3.0, 0.5 * (goal - start).norm());
  const Eigen::AlignedBox3d near(start.cwiseMin(goal) - Vector3d(reach, reach, 1.5),
                                 start.cwiseMax(goal) + Vector3d(reach, reach, 1.5));
  // Both ends are where they are, whatever the altitude limits say of the way between.
  const auto keepAltitude = [&](Eigen::AlignedBox3d box)
  {
    box.min().z() = std::max(box.min().z(), config.min_altitude_m);
    box.max().z() = std::min(box.max().z(), config.max_altitude_m);
    return box.extend(start).extend(goal);
  };
  auto found =
      search::findDistinctPaths(field, start, goal, keepAltitude(near), search_config, count);
  if (found.front().status == search::SearchStatus::Unreachable)
    found = search::findDistinctPaths(field, start, goal, keepAltitude(field.bounds()),
                                      search_config, count);
  GuideSearch result;
  result.nearest_L = found.front().nearest_L;
  result.reason = reasonFor(found.front().status);
  result.unreachable = found.front().status == search::SearchStatus::Unreachable;
  for (const search::SearchResult& way : found)
    if (way.status == search::SearchStatus::Found)
      result.guides.push_back(withLegs(start_L, way.path, goal_L));
  return result;
}

}  // namespace slalom::global_planner
