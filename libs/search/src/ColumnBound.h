// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "BucketQueue.h"

namespace slalom::search::detail
{
class Lattice;
using Walls = std::uint16_t;  ///< one bit per wall

/** What the way to the goal costs at least, seen from above: the cheapest way over the lattice's
 * columns, each as open and as cheap as its best point.
 *
 *  Exact on that plane, found backwards from the goal by A* towards the start that stops when it
 * has what was asked for, and goes on when more is asked. Where obstacles are upright, this is the
 * cost itself, for a fraction of the work that the full lattice takes. */
class ColumnBound
{
 public:
  struct Column
  {
    float cost, factor;  ///< [m] to the goal; [1] of the best point, infinite if none is open
    std::uint32_t seen = 0, stamp = 0;  ///< of the lattice, of the search
    Walls walls;                        ///< those that close all its open points
    std::uint8_t flooded, pocket;
  };
  struct Entry
  {
    std::uint32_t column;
    float cost;
  };
  struct Memory
  {
    std::vector<Column> columns;
    BucketQueue<Entry> queue;
    std::vector<std::uint32_t> flood;
  };

  /// @param seen names the lattice among all that used the memory
  ColumnBound(Lattice& lattice, Memory& memory, const Eigen::Vector3i& size, float resolution,
              std::uint32_t seen);

  /// @param stamp names the search; @param start,goal points per axis from the first of the lattice
  void begin(std::uint32_t stamp, const Eigen::Array2i& start, const Eigen::Array2f& goal,
             float goal_factor, float most_cost, Walls walls);
  /// Infinite if there is no way.
  [[nodiscard]] float toGoal(std::uint32_t column);
  /// What is known of that without more work: not more than it. `exact` tells whether it is all.
  [[nodiscard]] float toGoalAtLeast(std::uint32_t column, bool& exact);
  enum class Reach
  {
    Start,       ///< as far as this plane can tell
    GoalClosed,  ///< nothing that has a way to the goal is left
    StartClosed  ///< nothing that has a way to the start is left
  };
  /// Goes on to the column of the start, with a look at the start's surroundings if it takes long.
  [[nodiscard]] Reach reach();
  /// All columns with a way to a goal that proved closed are pockets from now on.
  void markPocket();
  [[nodiscard]] bool inPocket(std::uint32_t column) const
  {
    return memory_.columns[column].seen == seen_ && memory_.columns[column].pocket != 0;
  }
  /// Closes a column for the searches that name this wall.
  void close(std::uint32_t column, Walls wall);
  [[nodiscard]] bool isClosed(std::uint32_t column, Walls wall)
  {
    return (look(column).walls & wall) != 0;
  }

 private:
  Column& look(std::uint32_t column);
  [[nodiscard]] float toStart(std::uint32_t column) const;
  void offer(std::uint32_t column, float cost);
  void expand(std::uint32_t column);
  [[nodiscard]] bool settled(const Column& column, std::uint32_t index);
  [[nodiscard]] bool startIsClosedIn(std::size_t most);

  Lattice& lattice_;
  Memory& memory_;
  int nx_, ny_;
  float resolution_;
  struct Move
  {
    std::int32_t offset;
    float length;
  } moves_[8];
  std::uint32_t seen_, stamp_ = 0, start_ = 0;
  Eigen::Array2i start_at_ = Eigen::Array2i::Zero();
  float most_cost_ = 0.0f;
  Walls walls_ = 0;
};
}  // namespace slalom::search::detail
