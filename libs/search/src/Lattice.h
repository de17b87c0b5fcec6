// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "BucketQueue.h"
#include "ColumnBound.h"
#include "slalom/search/GridSearch.h"

namespace slalom::search::detail
{
using Path = std::vector<Eigen::Vector3d>;

/// Cost of travelling one metre at a distance from obstacles [1], >= 1.
[[nodiscard]] inline double costPerMetre(double distance, const GridSearchConfig& config)
{
  const double span = config.preferred_clearance_m - config.clearance_m;
  if (span <= 0.0 || distance >= config.preferred_clearance_m) return 1.0;
  return 1.0 + config.proximity_weight * (config.preferred_clearance_m - distance) / span;
}

/** The distance that a point's price goes by: that to what was seen, but not more in space that was
 * never seen. Never below the hard clearance where `distance` is not. */
[[nodiscard]] inline double pricedDistance(const core::DistanceField& field,
                                           const Eigen::Vector3d& p_L, double distance,
                                           const GridSearchConfig& config)
{
  const double span = config.preferred_clearance_m - config.clearance_m;
  if (config.unknown_weight <= 0.0 || span <= 0.0) return distance;
  const double most =
      config.preferred_clearance_m - span * config.unknown_weight / config.proximity_weight;
  if (distance <= most || field.occupancy(p_L) != core::Occupancy::Unknown) return distance;
  return most;
}

/// How the clearance between two open neighbours is established.
enum class EdgeCheck
{
  Euclidean,  ///< from both ends' distances, as exact distances allow; marched only if those are
              ///< short
  Marched     ///< marched unless both ends are far enough for any interpolated field
};

/// How a search ended.
enum class SearchEnd
{
  Found,
  StartExhausted,  ///< all that can be reached from the start was expanded
  GoalExhausted,  ///< all from which the goal could be reached was seen, and the start is not in it
  Limit
};

/** A* on the 26-connected points start + resolution (i, j, k) inside a region.
 *
 *  A point is open if it keeps the hard clearance; its distance is queried when it is first seen
 * and kept for all searches on the lattice. The goal is one more node, joined to the points around
 * it. Whether an edge keeps the clearance is looked at only when the search is about to use it. Its
 * memory is lent by the thread and given back, so that a search pays only for what it touches.
 *
 *  A wall closes points for the searches that name it. */
class Lattice
{
 public:
  static constexpr int kMostWalls = 16;

  Lattice(const core::DistanceField& field, const Eigen::Vector3d& start_L,
          const Eigen::AlignedBox3d& region_L, const GridSearchConfig& config);
  ~Lattice();
  Lattice(const Lattice&) = delete;
  Lattice& operator=(const Lattice&) = delete;

  /// False if the region has more points than can be searched.
  [[nodiscard]] bool usable() const { return usable_; }

  struct Query
  {
    Eigen::Vector3d goal_L;
    EdgeCheck edges = EdgeCheck::Euclidean;
    double most_cost = std::numeric_limits<double>::infinity();  ///< dearer paths are not wanted
    Walls walls = 0;
    int most_expansions = std::numeric_limits<int>::max();
  };
  /// Cost per metre at the best point of a column [1]; infinite if none is open.
  [[nodiscard]] float bestFactor(std::uint32_t column);

  /// From the start.
  [[nodiscard]] SearchEnd search(const Query& query);
  /// Start, lattice points, goal; after a search that found it.
  [[nodiscard]] Path path() const;
  /// All searches on this lattice; never more than config.max_expansions.
  [[nodiscard]] int expansions() const { return expansions_; }

  /** The point nearest to a place that can be reached from the start, after a search towards that
   * place that did not find it, or none at all (`end` empty). Best effort at the expansion limit.
   */
  [[nodiscard]] Eigen::Vector3d nearestReachable(const Eigen::Vector3d& place_L,
                                                 std::optional<SearchEnd> end);

  /** Closes, for searches that name this wall, the points of the plane through `at_L` across
   * `normal` that can be seen from `at_L` past obstacles nearer than `sight_m`. Only points from
   * which both ends are together within `most_m`. */
  void addWall(int wall, const Eigen::Vector3d& at_L, const Eigen::Vector3d& normal, double sight_m,
               const Eigen::Vector3d& goal_L, double most_m);
  /// True if a straight piece passes one of these walls.
  [[nodiscard]] bool crosses(Walls walls, const Eigen::Vector3d& a_L,
                             const Eigen::Vector3d& b_L) const;

 private:
  struct Cell
  {
    float cost, distance;  ///< cost is of the search that stamped it, distance of the lattice
    std::uint32_t stamp = 0;
    Walls walls;
    std::uint8_t parent;  ///< the move that led here
    std::uint8_t flags;
  };
  enum Flag : std::uint8_t
  {
    Closed = 1,   // by the search that stamped it: expanded
    Flooded = 2,  // seen from the goal
    Pocket = 4    // cannot be reached from the start
  };
  struct Entry
  {
    std::uint32_t cell;
    float cost;
    std::uint8_t move;
    bool sure;   ///< that the edge is clear
    bool exact;  ///< its priority, not a bound of that
  };
  struct Move
  {
    Eigen::Vector3i step;
    std::int32_t offset;
    std::int32_t column;  ///< which of the nine columns around a point, from 0
    float length;
    float sure_distance;  ///< an edge whose ends are at least this far is clear
  };
  struct Workspace
  {
    std::vector<Cell> cells;
    BucketQueue<Entry> queue;
    std::vector<std::uint32_t> expanded, flood;
    ColumnBound::Memory columns;
    std::uint32_t stamp = 0;
  };
  static Workspace& ofThisThread();

  void makeMoves();
  void setEdgeCheck(EdgeCheck edges);
  [[nodiscard]] Eigen::Vector3i coordinates(std::uint32_t cell) const;
  [[nodiscard]] std::uint32_t indexOf(const Eigen::Vector3i& at) const;
  [[nodiscard]] std::uint32_t columnOf(const Eigen::Vector3i& at) const
  {
    return static_cast<std::uint32_t>(at.x() - low_.x() + size_.x() * (at.y() - low_.y()));
  }
  [[nodiscard]] bool inside(const Eigen::Vector3i& at) const;
  [[nodiscard]] Eigen::Vector3d place(const Eigen::Vector3i& at) const;
  [[nodiscard]] Eigen::Vector3i nearestPoint(const Eigen::Vector3d& place_L) const;
  Cell& look(std::uint32_t cell, const Eigen::Vector3i& at);
  void ask(Cell& cell, const Eigen::Vector3i& at);
  [[nodiscard]] bool open(const Cell& cell) const { return cell.distance >= clearance_; }
  [[nodiscard]] float factor(const Cell& cell) const
  {
    return 1.0f + slope_ * std::max(0.0f, preferred_ - cell.distance);
  }
  void begin(const Query& query);
  SearchEnd run(const Query& query);
  /// Least cost from a point to the goal, given that from its column.
  [[nodiscard]] float toGoal(const Eigen::Vector3i& at, float from_column) const;
  /// Puts an entry back behind those that are better, now that its priority is known.
  void postpone(Entry entry);
  [[nodiscard]] bool edgeClear(const Entry& entry) const;
  void expand(std::uint32_t cell, const Query& query);
  void joinGoal(std::uint32_t from, const Eigen::Vector3d& from_L, const Query& query);
  void startFlood(const Query& query);
  [[nodiscard]] bool floodUpTo(std::size_t count, Walls walls);
  [[nodiscard]] std::optional<Eigen::Vector3d> nearestOpen(const Eigen::Vector3d& place_L);
  [[nodiscard]] Eigen::Vector3d nearestExpanded(const Eigen::Vector3d& place_L) const;
  void closeColumn(std::uint32_t column, Walls wall, const Eigen::Vector3d& goal_L, double most_m);
  [[nodiscard]] bool sees(const Eigen::Vector3d& from_L, const Eigen::Vector3d& to_L,
                          double sight_m);

  const core::DistanceField& field_;
  const GridSearchConfig& config_;
  Eigen::Vector3d start_L_;
  double resolution_;
  float clearance_, preferred_, slope_;
  Eigen::Vector3i low_, size_;  ///< lattice coordinates of the first point, points per axis; both
                                ///< with a margin of one point that is never open
  bool usable_ = false;
  Workspace work_;
  std::uint32_t seen_stamp_ = 0, search_stamp_ = 0;
  std::vector<Move> moves_;
  std::optional<ColumnBound> columns_;  ///< if usable
  int expansions_ = 0;
  // Of the search that is running.
  Eigen::Array3f goal_ = Eigen::Array3f::Zero();  ///< in lattice coordinates
  bool bounded_ = false;                          ///< by the columns
  float most_cost_ = 0.0f, goal_cost_ = 0.0f, goal_factor_ = 1.0f;
  std::uint32_t goal_parent_ = 0;
  Eigen::Vector3d goal_L_ = Eigen::Vector3d::Zero();
  std::size_t flood_next_ = 0;
  enum class Flood
  {
    NotBegun,
    Running,
    MetTheSearch
  } flood_state_ = Flood::NotBegun;
};
}  // namespace slalom::search::detail
