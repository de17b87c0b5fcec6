// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "Lattice.h"
#include "slalom/search/GridSearch.h"

namespace slalom::search::detail
{
/// One question: from here to there in this field. All its searches share one lattice.
class PathFinder
{
 public:
  /// @throws std::invalid_argument on a config that makes no sense
  PathFinder(const core::DistanceField& field, const Eigen::Vector3d& start_L,
             const Eigen::Vector3d& goal_L, const Eigen::AlignedBox3d& box_L,
             const GridSearchConfig& config);

  /// What findPath() returns.
  [[nodiscard]] SearchResult first();
  /// Shortcut path that crosses none of the walls and costs no more than `most_cost` before it was
  /// shortcut.
  [[nodiscard]] SearchResult around(Walls walls, double most_cost, int most_expansions);
  /// The points that are searched; nullptr if they are too many.
  [[nodiscard]] Lattice* lattice();

 private:
  [[nodiscard]] std::optional<SearchStatus> blockedEnd(SearchResult& result);
  void searchOn(Lattice& lattice, Lattice::Query query, SearchResult& result);

  const core::DistanceField& field_;
  const GridSearchConfig& config_;
  Eigen::Vector3d start_L_, goal_L_;
  Eigen::AlignedBox3d region_L_;
  std::optional<Lattice> lattice_;
};
}  // namespace slalom::search::detail
