// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>

#include "Lattice.h"

namespace slalom::search::detail
{
namespace
{
/// The cost found is at most this times the smallest, and one bucket more.
constexpr float kGreed = 1.045f;
/// Width of a bucket as a share of the straight distance; with the greed that makes 1.05.
constexpr float kBucketShare = 0.005f;
/// The goal's surroundings are looked at when a search has become this long, and again at four
/// times that.
constexpr int kFirstFlood = 256;
/// Cell of the goal: a corner of the margin, which no search can enter.
constexpr std::uint32_t kGoal = 0;

/// Shortest way between two points on an empty lattice of edge one.
float latticeDistance(float x, float y, float z)
{
  const float most = std::max({x, y, z}), least = std::min({x, y, z});
  const float middle = x + y + z - most - least;
  constexpr float kSqrt2 = 1.41421356f, kSqrt3 = 1.73205081f;
  return (kSqrt3 - kSqrt2) * least + (kSqrt2 - 1.0f) * middle + most;
}
}  // namespace

void Lattice::begin(const Query& query)
{
  search_stamp_ = ++work_.stamp;
  setEdgeCheck(query.edges);
  goal_L_ = query.goal_L;
  goal_ = ((query.goal_L - start_L_) / resolution_).cast<float>().array();
  goal_cost_ = std::numeric_limits<float>::infinity();
  most_cost_ = static_cast<float>(query.most_cost);
  const auto at_goal = field_.distance(query.goal_L, core::UnknownAs::Free);
  goal_factor_ = static_cast<float>(
      costPerMetre(pricedDistance(field_, query.goal_L, at_goal.value_or(0.0), config_), config_));
  flood_state_ = Flood::NotBegun;
  work_.expanded.clear();

  const std::uint32_t start = indexOf(Eigen::Vector3i::Zero());
  look(start, Eigen::Vector3i::Zero());
  const auto resolution = static_cast<float>(resolution_);
  const Eigen::Array3f offset = goal_.abs();
  const float straight = resolution * latticeDistance(offset.x(), offset.y(), offset.z());
  work_.queue.reset(straight, kBucketShare * std::max(straight, resolution));
  work_.queue.push(kGreed * straight, {start, 0.0f, 0, true, true});
}

SearchEnd Lattice::search(const Query& query)
{
  begin(query);
  const Eigen::Array2f goal = goal_.head<2>() - low_.head<2>().cast<float>().array();
  columns_->begin(search_stamp_, -low_.head<2>().array(), goal, goal_factor_, most_cost_,
                  query.walls);
  const ColumnBound::Reach reach = columns_->reach();
  if (reach != ColumnBound::Reach::Start && query.walls != 0) return SearchEnd::StartExhausted;
  if (reach == ColumnBound::Reach::GoalClosed)
  {
    columns_->markPocket();
    return SearchEnd::GoalExhausted;
  }
  // If there is no way, it is still wanted what can be reached.
  bounded_ = reach == ColumnBound::Reach::Start;
  const SearchEnd end = run(query);
  // What is behind a wall is not out of reach.
  const bool pocket = end == SearchEnd::GoalExhausted && query.walls == 0;
  for (const std::uint32_t cell : work_.flood)
    if (pocket)
      work_.cells[cell].flags |= Pocket;
    else
      work_.cells[cell].flags &= static_cast<std::uint8_t>(~Flooded);
  work_.flood.clear();
  return end;
}

SearchEnd Lattice::run(const Query& query)
{
  int next_flood = expansions_ + kFirstFlood;
  const int left = std::min(config_.max_expansions - expansions_, query.most_expansions);
  Entry entry;
  while (work_.queue.pop(entry))
  {
    if (entry.cell == kGoal)
    {
      if (entry.cost > goal_cost_) continue;
      return SearchEnd::Found;
    }
    Cell& cell = work_.cells[entry.cell];
    if (cell.stamp == search_stamp_ && ((cell.flags & Closed) || entry.cost > cell.cost)) continue;
    if (!entry.exact)
    {
      postpone(entry);
      continue;
    }
    if (!entry.sure && !edgeClear(entry)) continue;
    if (static_cast<int>(work_.expanded.size()) >= left) return SearchEnd::Limit;
    ++expansions_;
    if (cell.stamp != search_stamp_) cell.stamp = search_stamp_;
    cell.cost = entry.cost;
    cell.parent = entry.move;
    cell.flags |= Closed;
    work_.expanded.push_back(entry.cell);
    expand(entry.cell, query);
    if (expansions_ < next_flood) continue;
    next_flood = 4 * expansions_;
    if (flood_state_ == Flood::NotBegun) startFlood(query);
    if (floodUpTo(work_.expanded.size(), query.walls)) return SearchEnd::GoalExhausted;
  }
  return SearchEnd::StartExhausted;
}

float Lattice::toGoal(const Eigen::Vector3i& at, float from_column) const
{
  const auto resolution = static_cast<float>(resolution_);
  const Eigen::Array3f left = (goal_ - at.cast<float>().array()).abs();
  const float climb = resolution * left.z();
  return std::max(resolution * latticeDistance(left.x(), left.y(), left.z()),
                  std::sqrt(from_column * from_column + climb * climb));
}

void Lattice::postpone(Entry entry)
{
  const Eigen::Vector3i at = coordinates(entry.cell);
  const float to_go = toGoal(at, columns_->toGoal(columnOf(at)));
  if (!(entry.cost + to_go <= most_cost_)) return;
  entry.exact = true;
  work_.queue.push(entry.cost + kGreed * to_go, entry);
}

bool Lattice::edgeClear(const Entry& entry) const
{
  const Eigen::Vector3i at = coordinates(entry.cell);
  return segmentClear(field_, place(at - moves_[entry.move].step), place(at), config_.clearance_m);
}

void Lattice::joinGoal(std::uint32_t from, const Eigen::Vector3d& from_L, const Query& query)
{
  const Cell& cell = work_.cells[from];
  const auto length = static_cast<float>((query.goal_L - from_L).norm());
  const float cost = cell.cost + length * 0.5f * (factor(cell) + goal_factor_);
  if (cost >= goal_cost_ || !segmentClear(field_, from_L, query.goal_L, config_.clearance_m))
    return;
  goal_cost_ = cost;
  goal_parent_ = from;
  work_.queue.push(cost, {kGoal, cost, 0, true, true});
}

void Lattice::expand(std::uint32_t index, const Query& query)
{
  const Cell here = work_.cells[index];
  const Eigen::Vector3i at = coordinates(index);
  const Eigen::Array3f offset = goal_ - at.cast<float>().array();
  if (offset.abs().maxCoeff() <= 1.001f) joinGoal(index, place(at), query);

  // Of the columns around, when first wanted.
  struct Above
  {
    float flat = -1.0f;
    bool exact = true;
  };
  std::array<Above, 9> above;

  const float here_factor = factor(here);
  for (std::size_t m = 0; m < moves_.size(); ++m)
  {
    const Move& move = moves_[m];
    const auto neighbour =
        static_cast<std::uint32_t>(static_cast<std::int32_t>(index) + move.offset);
    Cell& there = work_.cells[neighbour];
    if (there.stamp < seen_stamp_) ask(there, at + move.step);
    const bool fresh = there.stamp != search_stamp_;
    if (!open(there) || (there.walls & query.walls) || (!fresh && (there.flags & Closed))) continue;
    const float cost = here.cost + move.length * 0.5f * (here_factor + factor(there));
    if (!fresh && cost >= there.cost) continue;
    Above& column = above[static_cast<std::size_t>(move.column)];
    if (column.flat < 0.0f)
      column.flat =
          bounded_ ? columns_->toGoalAtLeast(columnOf(at + move.step), column.exact) : 0.0f;
    const float to_go = toGoal(at + move.step, column.flat);
    if (!(cost + to_go <= most_cost_)) continue;
    const bool sure = std::min(here.distance, there.distance) >= move.sure_distance;
    if (fresh)
    {
      there.stamp = search_stamp_;
      there.flags &= static_cast<std::uint8_t>(~Closed);
      there.cost = std::numeric_limits<float>::infinity();
    }
    // An edge that may prove blocked must not hide the others.
    if (sure) there.cost = cost;
    work_.queue.push(cost + kGreed * to_go,
                     {neighbour, cost, static_cast<std::uint8_t>(m), sure, column.exact});
  }
}

Path Lattice::path() const
{
  const std::uint32_t start = indexOf(Eigen::Vector3i::Zero());
  Path path = {goal_L_};
  Eigen::Vector3i at = coordinates(goal_parent_);
  for (std::uint32_t cell = goal_parent_; cell != start;)
  {
    path.push_back(place(at));
    const Move& move = moves_[work_.cells[cell].parent];
    at -= move.step;
    cell = static_cast<std::uint32_t>(static_cast<std::int32_t>(cell) - move.offset);
  }
  path.push_back(start_L_);
  std::reverse(path.begin(), path.end());
  return path;
}

}  // namespace slalom::search::detail
