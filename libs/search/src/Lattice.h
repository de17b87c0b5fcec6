// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <optional>
#include <vector>

#include "slalom/search/GridSearch.h"

namespace slalom::search::detail
{
/// Cost of travelling one metre at a distance from obstacles [1], >= 1.
[[nodiscard]] inline double costPerMetre(double distance, const GridSearchConfig& config)
{
  const double span = config.preferred_clearance_m - config.clearance_m;
  if (span <= 0.0 || distance >= config.preferred_clearance_m) return 1.0;
  return 1.0 + config.proximity_weight * (config.preferred_clearance_m - distance) / span;
}

/// How the clearance between two open neighbours is established.
enum class EdgeCheck
{
  Euclidean,  ///< from both ends' distances, as exact distances allow; marched only if those are
              ///< short
  Marched     ///< marched unless both ends are far enough for any interpolated field
};

/** A* on the 26-connected points start + resolution (i, j, k) inside a region.
 *
 *  A point is open if it keeps the hard clearance; distances are queried when a point is first
 * seen. The goal is one more node, joined to the points around it. Ties are broken by insertion
 * order. */
class Lattice
{
 public:
  Lattice(const core::DistanceField& field, const Eigen::Vector3d& start_L,
          const Eigen::AlignedBox3d& region_L, const GridSearchConfig& config, EdgeCheck edges);

  /// False if the region has more points than can be searched.
  [[nodiscard]] bool usable() const { return cells_ != nullptr; }

  /// Start, lattice points, goal; nullopt if not reached.
  [[nodiscard]] std::optional<std::vector<Eigen::Vector3d>> search(const Eigen::Vector3d& goal_L);
  /// Open point nearest to a place, reachable or not.
  [[nodiscard]] std::optional<Eigen::Vector3d> nearestOpen(const Eigen::Vector3d& place_L);

  [[nodiscard]] int expansions() const { return expansions_; }
  [[nodiscard]] bool limited() const { return limited_; }
  /// Expanded point nearest to a place; the start if none was expanded.
  [[nodiscard]] Eigen::Vector3d nearestExpanded(const Eigen::Vector3d& place_L) const;

 private:
  enum State : std::uint32_t
  {
    Unseen,  // zero: what fresh memory holds
    Blocked,
    Open,
    Expanded
  };
  struct Cell
  {
    float cost, distance;
    std::uint32_t parent;
    State state;
  };
  struct Entry
  {
    float priority;
    std::uint32_t order, cell;
    /// Heap order: the top is the smallest priority, then the oldest.
    bool operator<(const Entry& other) const
    {
      return priority != other.priority ? priority > other.priority : order > other.order;
    }
  };
  struct Move
  {
    Eigen::Vector3i step;
    std::int64_t offset;
    float length;
    float sure_distance;  ///< an edge whose ends are at least this far is clear
  };
  struct Free
  {
    void operator()(void* memory) const { std::free(memory); }
  };

  void makeMoves(double clearance, EdgeCheck edges);
  [[nodiscard]] Eigen::Vector3i coordinates(std::uint32_t cell) const;
  [[nodiscard]] std::uint32_t indexOf(const Eigen::Vector3i& at) const;
  [[nodiscard]] bool inside(const Eigen::Vector3i& at) const;
  [[nodiscard]] Eigen::Vector3d place(const Eigen::Vector3i& at) const;
  State look(std::uint32_t cell, const Eigen::Vector3i& at);
  void expand(std::uint32_t cell, const Eigen::Vector3d& goal_L);
  void joinGoal(std::uint32_t from, const Eigen::Vector3d& from_L, const Eigen::Vector3d& goal_L);
  void push(std::uint32_t cell, double priority);

  const core::DistanceField& field_;
  const GridSearchConfig& config_;
  Eigen::Vector3d start_L_;
  double resolution_, greed_;
  Eigen::Vector3i low_, size_;  ///< lattice coordinates of the first point, points per axis
  std::uint32_t goal_node_ = 0;
  std::unique_ptr<Cell[], Free> cells_;  ///< one more than there are points: the goal
  std::vector<Move> moves_;
  std::vector<Entry> heap_;
  std::vector<std::uint32_t> expanded_;
  std::uint32_t pushed_ = 0;
  int expansions_ = 0;
  bool limited_ = false;
};
}  // namespace slalom::search::detail
