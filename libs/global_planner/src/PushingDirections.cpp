// SPDX-License-Identifier: BSD-3-Clause
#include "slalom/global_planner/PushingDirections.h"

#include <algorithm>
#include <cmath>

#include "slalom/geometry/ConvexDecomposition.h"
#include "slalom/optim/PathQp.h"
#include "slalom/search/GridSearch.h"

namespace slalom::global_planner
{
namespace
{
using core::HalfSpaces;

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

/// Moves a point up the distance gradient until it keeps `clearance`, at most two metres.
Eigen::Vector3d escape(const core::DistanceField& field, Eigen::Vector3d p_L, double clearance)
{
  for (int i = 0; i < 10; ++i)
  {
    const auto here = field.sample(p_L, core::UnknownAs::Free);
    if (!here || here->distance >= clearance || here->gradient.norm() < 1e-3) break;
    p_L += here->gradient.normalized() * std::min(0.2, clearance - here->distance + 1e-3);
  }
  return p_L;
}

/// Cuts every edge into equal pieces not longer than `longest`.
Eigen::Matrix3Xd cutIntoPieces(const Eigen::Matrix3Xd& path, double longest)
{
  std::vector<Eigen::Vector3d> points{path.col(0)};
  for (Eigen::Index k = 0; k + 1 < path.cols(); ++k)
  {
    const Eigen::Vector3d edge = path.col(k + 1) - path.col(k);
    const int pieces = std::max(1, static_cast<int>(std::ceil(edge.norm() / longest)));
    for (int i = 1; i <= pieces; ++i) points.push_back(path.col(k) + edge * (double(i) / pieces));
  }
  Eigen::Matrix3Xd cut(3, static_cast<Eigen::Index>(points.size()));
  for (std::size_t i = 0; i < points.size(); ++i) cut.col(static_cast<Eigen::Index>(i)) = points[i];
  return cut;
}

std::vector<HalfSpaces> decomposeAlong(const core::DistanceField& field,
                                       const Eigen::Matrix3Xd& pieces, double shrink,
                                       const GlobalPlannerConfig& config)
{
  geometry::DecompositionConfig shape;
  shape.along_m = config.box_along_m;
  shape.lateral_m = config.box_lateral_m;
  shape.vertical_m = config.box_vertical_m;
  shape.shrink_m = shrink;
  std::vector<std::vector<Eigen::Vector3d>> obstacles(static_cast<std::size_t>(pieces.cols() - 1));
  for (Eigen::Index k = 0; k + 1 < pieces.cols(); ++k)
    field.collectObstacles(geometry::localBox(pieces.col(k), pieces.col(k + 1), shape),
                           core::UnknownAs::Free, obstacles[static_cast<std::size_t>(k)]);
  std::vector<geometry::FreePolyhedron> free =
      geometry::decomposeParallel(pieces, obstacles, shape, config.threads);
  std::vector<HalfSpaces> sets;
  sets.reserve(free.size());
  for (std::size_t k = 0; k < free.size(); ++k)
  {
    if (!free[k].contains_seed)
    {
      // The guide keeps its clearance, but a tangent plane may be steeper than the way to the
      // nearest obstacle: move the offending planes back to the seed so that the program stays
      // feasible.
      HalfSpaces& set = free[k].set;
      for (Eigen::Index row = 0; row < set.rows(); ++row)
        set.b[row] = std::max({set.b[row], set.A.row(row).dot(pieces.col(Eigen::Index(k))),
                               set.A.row(row).dot(pieces.col(Eigen::Index(k) + 1))});
    }
    sets.push_back(std::move(free[k].set));
  }
  return sets;
}

/// Arc length up to each column.
Eigen::VectorXd arcLength(const Eigen::Matrix3Xd& path)
{
  Eigen::VectorXd s = Eigen::VectorXd::Zero(path.cols());
  for (Eigen::Index k = 1; k < path.cols(); ++k)
    s[k] = s[k - 1] + (path.col(k) - path.col(k - 1)).norm();
  return s;
}

/// Point j of n belongs to the piece at its share of the arc length; near a joint it belongs to
/// both neighbours.
std::vector<std::vector<const HalfSpaces*>> assign(const Eigen::VectorXd& s, Eigen::Index points,
                                                   const std::vector<HalfSpaces>& sets)
{
  std::vector<std::vector<const HalfSpaces*>> assigned(static_cast<std::size_t>(points));
  const double spacing = s[s.size() - 1] / static_cast<double>(points - 1);
  for (Eigen::Index j = 0; j < points; ++j)
  {
    const double at = spacing * static_cast<double>(j);
    for (std::size_t k = 0; k < sets.size(); ++k)
    {
      const double lo = s[Eigen::Index(k)], hi = s[Eigen::Index(k) + 1];
      if (at >= lo - 0.5 * spacing && at <= hi + 0.5 * spacing)
        assigned[std::size_t(j)].push_back(&sets[k]);
    }
  }
  return assigned;
}

Eigen::Matrix3Xd resample(const Eigen::Matrix3Xd& path, const Eigen::VectorXd& s,
                          Eigen::Index points)
{
  Eigen::Matrix3Xd even(3, points);
  Eigen::Index k = 0;
  for (Eigen::Index j = 0; j < points; ++j)
  {
    const double at = s[s.size() - 1] * static_cast<double>(j) / static_cast<double>(points - 1);
    while (k + 2 < s.size() && s[k + 1] < at) ++k;
    const double length = s[k + 1] - s[k];
    const double u = length > 0.0 ? std::clamp((at - s[k]) / length, 0.0, 1.0) : 0.0;
    even.col(j) = (1.0 - u) * path.col(k) + u * path.col(k + 1);
  }
  return even;
}

/// Dead-zone recovery [Paper Eq. (5)]: every point moves to the nearest point of its own
/// polyhedron.
Eigen::Matrix3Xd projectAll(Eigen::Matrix3Xd points,
                            const std::vector<std::vector<const HalfSpaces*>>& sets)
{
  for (Eigen::Index j = 0; j < points.cols(); ++j)
    if (!sets[std::size_t(j)].empty())
      if (const auto nearest = geometry::project(points.col(j), *sets[std::size_t(j)].front()))
        points.col(j) = *nearest;
  return points;
}

}  // namespace

GuideSearch searchGuides(const core::DistanceField& field, const Eigen::Vector3d& start_L,
                         const Eigen::Vector3d& goal_L, double hard_clearance, int count,
                         const GlobalPlannerConfig& config)
{
  search::GridSearchConfig search_config;
  search_config.clearance_m = hard_clearance;
  search_config.preferred_clearance_m = std::max(config.clearance_m, hard_clearance);
  search_config.proximity_weight = config.guide_proximity_weight;
  const Eigen::Vector3d start = escape(field, start_L, 1.02 * hard_clearance);
  const Eigen::Vector3d goal = escape(field, goal_L, 1.02 * hard_clearance);
  const double reach = std::max(3.0, 0.5 * (goal - start).norm());
  Eigen::AlignedBox3d near(start.cwiseMin(goal) - Eigen::Vector3d(reach, reach, 1.5),
                           start.cwiseMax(goal) + Eigen::Vector3d(reach, reach, 1.5));
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
  for (search::SearchResult& way : found)
    if (way.status == search::SearchStatus::Found) result.guides.push_back(std::move(way.path));
  return result;
}

PushingPath pushAlong(const core::DistanceField& field, const Eigen::Matrix3Xd& guide,
                      Eigen::Index points, double hard_clearance, const GlobalPlannerConfig& config)
{
  PushingPath result;
  result.guide = guide;
  const Eigen::Matrix3Xd pieces = cutIntoPieces(guide, config.piece_m);
  // Obstacles are voxel centres, the clearance counts from their surface.
  result.polyhedra =
      decomposeAlong(field, pieces, hard_clearance + 0.5 * field.resolution(), config);

  const Eigen::VectorXd s = arcLength(pieces);
  optim::PathQp program;
  program.first = guide.col(0);
  program.last = guide.col(guide.cols() - 1);
  program.points = points;
  program.sets = assign(s, points, result.polyhedra);
  program.margin = std::max(0.0, config.clearance_m - hard_clearance);
  const optim::PathQpSolution solution = optim::solve(program);
  result.solve = solution.report;
  result.found = true;
  if (solution.report.converged())
    result.path = solution.points;
  else
  {
    result.path = projectAll(resample(pieces, s, points), program.sets);
    result.recovered = true;
    result.reason = "pushing program " + std::string(toString(solution.report.termination)) +
                    ", points projected";
  }
  return result;
}

}  // namespace slalom::global_planner
