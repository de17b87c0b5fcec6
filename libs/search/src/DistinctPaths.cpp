// SPDX-License-Identifier: BSD-3-Clause
#include "slalom/search/DistinctPaths.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "ArcLength.h"
#include "PathFinder.h"

namespace slalom::search
{
namespace
{
using detail::ArcLength;
using detail::Lattice;
using detail::PathFinder;
using detail::Walls;

constexpr std::size_t kMostPaths = 3;
constexpr std::size_t kMostNecks = 4;  ///< of a path that are tried
constexpr int kMostTries = 4;          ///< paths whose necks are
static_assert(kMostNecks * kMostTries <= Lattice::kMostWalls);

/// A place where a path passes an obstacle closer than before and after.
struct Neck
{
  Eigen::Vector3d at_L, direction;
  double clearance;
};

/// The narrowest first.
std::vector<Neck> necksOf(const core::DistanceField& field, const Eigen::Matrix3Xd& path,
                          const GridSearchConfig& config)
{
  const ArcLength arc(path);
  const double r = field.resolution();
  const int count = std::max(2, static_cast<int>(std::ceil(arc.length() / (0.5 * r))));
  std::vector<double> distance;
  for (int i = 0; i <= count; ++i)
    distance.push_back(
        field.distance(arc.at(arc.length() * i / count), core::UnknownAs::Free).value_or(0.0));

  std::vector<Neck> necks;
  for (int i = 0; i <= count; ++i)
  {
    const double d = distance[i];
    const bool end = i == 0 || i == count;
    // At an end the path has no closer place behind it, but may just have left one.
    if (d >= (end ? config.preferred_clearance_m : field.maxDistance() - 1e-6)) continue;
    if ((i > 0 && distance[i - 1] <= d) || (i < count && distance[i + 1] < d)) continue;
    // A wall through an end would close all ways.
    const double s = std::clamp(arc.length() * i / count, std::min(1.5 * r, 0.5 * arc.length()),
                                std::max(arc.length() - 1.5 * r, 0.5 * arc.length()));
    const Eigen::Vector3d direction = arc.at(s + r) - arc.at(s - r);
    if (direction.norm() > 1e-6) necks.push_back({arc.at(s), direction, d});
  }
  std::stable_sort(necks.begin(), necks.end(),
                   [](const Neck& a, const Neck& b) { return a.clearance < b.clearance; });
  if (necks.size() > kMostNecks) necks.resize(kMostNecks);
  return necks;
}

/// Finds paths by closing passages.
class Alternatives
{
 public:
  Alternatives(PathFinder& finder, const core::DistanceField& field, const Eigen::Vector3d& goal_L,
               const GridSearchConfig& config, const SearchResult& first, std::size_t wanted)
      : finder_(finder),
        field_(field),
        goal_L_(goal_L),
        config_(config),
        most_cost_(config.max_detour * first.cost_m),
        wanted_(wanted),
        expansions_left_(config.max_alternative_expansions)
  {
    kept_.push_back({first, 0});
    // What an alternative leads to is dearer than itself: the last that is wanted is not tried.
    for (int tries = 0; tries < kMostTries; ++tries)
    {
      const auto next = std::find_if(kept_.begin(), kept_.end(),
                                     [](const Candidate& path) { return !path.tried; });
      if (next == kept_.end() || next - kept_.begin() + 1 == static_cast<int>(wanted_)) break;
      next->tried = true;
      closePassagesOf(*next);
    }
  }
  [[nodiscard]] std::vector<SearchResult> take()
  {
    std::vector<SearchResult> paths;
    for (Candidate& candidate : kept_) paths.push_back(std::move(candidate.result));
    return paths;
  }

 private:
  struct Candidate
  {
    SearchResult result;
    Walls walls;  ///< that it avoids
    bool tried = false;
  };
  /// Shortcuts make paths cheaper by a few per cent.
  static constexpr double kBeforeShortcut = 1.1;

  /// Searches for ways that avoid one passage of this path each, and those it avoids itself.
  void closePassagesOf(const Candidate path)
  {
    Lattice* lattice = finder_.lattice();
    if (!lattice) return;
    const double c = config_.clearance_m, r = field_.resolution();
    // Closed as far as one can see past obstacles, not past the margin around them: just behind a
    // margin is no other way. Lattice points are up to 0.87 voxel from the line of sight.
    const double sight = std::max(0.0, std::min(0.5 * c, c - 0.9 * r));
    for (const Neck& neck : necksOf(field_, path.result.path, config_))
    {
      const double most = kBeforeShortcut * most_cost_;
      const int wall = walls_made_++;
      lattice->addWall(wall, neck.at_L, neck.direction, sight, goal_L_, most);
      const auto all = static_cast<Walls>(path.walls | (1u << wall));
      SearchResult found = finder_.around(all, most, expansions_left_);
      expansions_left_ -= found.expansions;
      if (found.status == SearchStatus::Found && found.cost_m <= most_cost_)
        keep({std::move(found), all});
    }
  }
  /// Sorted behind the first, the cheapest of each class; dearer than the last that is wanted is
  /// not wanted.
  void keep(Candidate&& found)
  {
    const auto same = [&](const Candidate& other)
    { return deformable(field_, other.result.path, found.result.path, config_.clearance_m); };
    const auto cheaper = [&](const Candidate& other)
    { return other.result.cost_m <= found.result.cost_m; };
    if (same(kept_[0])) return;
    const auto place = std::find_if_not(kept_.begin() + 1, kept_.end(), cheaper);
    if (std::any_of(kept_.begin() + 1, place, same)) return;
    const auto index = place - kept_.begin();
    kept_.erase(std::remove_if(place, kept_.end(), same), kept_.end());
    kept_.insert(kept_.begin() + index, std::move(found));
    if (kept_.size() > wanted_) kept_.pop_back();
    if (kept_.size() == wanted_) most_cost_ = kept_.back().result.cost_m;
  }

  PathFinder& finder_;
  const core::DistanceField& field_;
  Eigen::Vector3d goal_L_;
  const GridSearchConfig& config_;
  double most_cost_;
  std::size_t wanted_;
  int walls_made_ = 0, expansions_left_;
  std::vector<Candidate> kept_;
};
}  // namespace

std::vector<SearchResult> findDistinctPaths(const core::DistanceField& field,
                                            const Eigen::Vector3d& start_L,
                                            const Eigen::Vector3d& goal_L,
                                            const Eigen::AlignedBox3d& box_L,
                                            const GridSearchConfig& config, int max_paths)
{
  if (max_paths < 1 || max_paths > static_cast<int>(kMostPaths))
    throw std::invalid_argument("findDistinctPaths: max_paths = " + std::to_string(max_paths) +
                                ", must be in 1..3");
  PathFinder finder(field, start_L, goal_L, box_L, config);
  std::vector<SearchResult> paths = {finder.first()};
  if (paths[0].status != SearchStatus::Found || max_paths == 1) return paths;

  return Alternatives(finder, field, goal_L, config, paths[0], static_cast<std::size_t>(max_paths))
      .take();
}

bool deformable(const core::DistanceField& field, const Eigen::Matrix3Xd& a_L,
                const Eigen::Matrix3Xd& b_L, double clearance_m)
{
  const ArcLength a(a_L), b(b_L);
  int count = 1;
  while (count * field.resolution() < std::max(a.length(), b.length())) count *= 2;
  // The middle first, then the quarters: paths that differ do so far from their ends.
  for (int stride = count; stride >= 2; stride /= 2)
    for (int i = stride / 2; i < count; i += stride)
    {
      const double share = static_cast<double>(i) / count;
      if (!segmentClear(field, a.at(share * a.length()), b.at(share * b.length()), clearance_m))
        return false;
    }
  return true;
}

}  // namespace slalom::search
