// SPDX-License-Identifier: BSD-3-Clause
#include "ColumnBound.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>

#include "Lattice.h"

namespace slalom::search::detail
{
namespace
{
constexpr float kInfinity = std::numeric_limits<float>::infinity();
/// The start's surroundings are looked at when this many columns were expanded, and again at four
/// times that.
constexpr std::size_t kFirstFlood = 256;
}  // namespace

ColumnBound::ColumnBound(Lattice& lattice, Memory& memory, const Eigen::Vector3i& size,
                         float resolution, std::uint32_t seen)
    : lattice_(lattice),
      memory_(memory),
      nx_(size.x()),
      ny_(size.y()),
      resolution_(resolution),
      seen_(seen)
{
  const auto count = static_cast<std::size_t>(nx_) * static_cast<std::size_t>(ny_);
  if (memory_.columns.size() < count) memory_.columns.resize(count);
  int i = 0;
  for (int dy = -1; dy <= 1; ++dy)
    for (int dx = -1; dx <= 1; ++dx)
      if (dx != 0 || dy != 0)
        moves_[i++] = {dx + nx_ * dy,
                       resolution_ * std::sqrt(static_cast<float>(dx * dx + dy * dy))};
}

void ColumnBound::begin(std::uint32_t stamp, const Eigen::Array2i& start,
                        const Eigen::Array2f& goal, float goal_factor, float most_cost, Walls walls)
{
  most_cost_ = most_cost;
  stamp_ = stamp;
  walls_ = walls;
  start_at_ = start;
  start_ = static_cast<std::uint32_t>(start.x() + nx_ * start.y());
  memory_.queue.reset(0.0f, 0.5f * resolution_);
  const Eigen::Array2i low = (goal - 1.001f).ceil().max(0.0f).cast<int>();
  const Eigen::Array2i high = (goal + 1.001f).floor().cast<int>().min(Eigen::Array2i(nx_, ny_) - 1);
  for (int y = low.y(); y <= high.y(); ++y)
    for (int x = low.x(); x <= high.x(); ++x)
    {
      const auto column = static_cast<std::uint32_t>(x + nx_ * y);
      const float length = resolution_ * std::hypot(goal.x() - static_cast<float>(x),
                                                    goal.y() - static_cast<float>(y));
      offer(column, length * 0.5f * (look(column).factor + goal_factor));
    }
}

ColumnBound::Column& ColumnBound::look(std::uint32_t index)
{
  Column& column = memory_.columns[index];
  if (column.seen != seen_)
  {
    column.seen = seen_;
    column.walls = 0;
    column.flooded = column.pocket = 0;
    column.factor = lattice_.bestFactor(index);
  }
  if (column.stamp != stamp_)
  {
    column.stamp = stamp_;
    column.cost = kInfinity;
  }
  return column;
}

void ColumnBound::close(std::uint32_t column, Walls wall)
{
  look(column).walls |= wall;
}

float ColumnBound::toStart(std::uint32_t column) const
{
  const int x = std::abs(static_cast<int>(column) % nx_ - start_at_.x());
  const int y = std::abs(static_cast<int>(column) / nx_ - start_at_.y());
  constexpr float kSqrt2 = 1.41421356f;
  return resolution_ * (static_cast<float>(std::max(x, y)) +
                        (kSqrt2 - 1.0f) * static_cast<float>(std::min(x, y)));
}

void ColumnBound::offer(std::uint32_t index, float cost)
{
  Column& column = memory_.columns[index];
  if (!(cost < column.cost) || (column.walls & walls_)) return;
  const float through = cost + toStart(index);
  if (through > most_cost_) return;
  column.cost = cost;
  memory_.queue.push(through, {index, cost});
}

void ColumnBound::expand(std::uint32_t index)
{
  const Column here = memory_.columns[index];
  for (const Move& move : moves_)
  {
    const auto next = static_cast<std::uint32_t>(static_cast<std::int32_t>(index) + move.offset);
    offer(next, here.cost + move.length * 0.5f * (here.factor + look(next).factor));
  }
}

/// Costs are corrected within a bucket; before the front one they are final.
bool ColumnBound::settled(const Column& column, std::uint32_t index)
{
  return column.cost < kInfinity && memory_.queue.before(column.cost + toStart(index));
}

float ColumnBound::toGoal(std::uint32_t index)
{
  const Column& column = look(index);
  if (!(column.factor < kInfinity) || (column.walls & walls_)) return kInfinity;
  Entry entry;
  while (!settled(column, index) && memory_.queue.pop(entry))
    if (entry.cost <= memory_.columns[entry.column].cost) expand(entry.column);
  return column.cost;
}

float ColumnBound::toGoalAtLeast(std::uint32_t index, bool& exact)
{
  const Column& column = memory_.columns[index];
  const bool known = column.seen == seen_ && column.stamp == stamp_;
  exact = known && settled(column, index);
  // The ways that the search has still to follow are not shorter than its next.
  return exact ? column.cost : std::max(0.0f, memory_.queue.lowest() - toStart(index));
}

ColumnBound::Reach ColumnBound::reach()
{
  const Column& column = look(start_);
  std::size_t expanded = 0, next_flood = kFirstFlood;
  Entry entry;
  while (!settled(column, start_) && memory_.queue.pop(entry))
  {
    if (entry.cost > memory_.columns[entry.column].cost) continue;
    expand(entry.column);
    if (++expanded < next_flood) continue;
    next_flood = 4 * expanded;
    if (walls_ == 0 && startIsClosedIn(expanded)) return Reach::StartClosed;
  }
  return column.cost < kInfinity ? Reach::Start : Reach::GoalClosed;
}

void ColumnBound::markPocket()
{
  const auto count = static_cast<std::size_t>(nx_) * static_cast<std::size_t>(ny_);
  for (std::size_t i = 0; i < count; ++i)
    if (memory_.columns[i].stamp == stamp_ && memory_.columns[i].cost < kInfinity)
      memory_.columns[i].pocket = 1;
}

/// True if less than `most` columns can be reached from the start, and the goal from none of them.
bool ColumnBound::startIsClosedIn(std::size_t most)
{
  std::vector<std::uint32_t>& flood = memory_.flood;
  flood.assign(1, start_);
  memory_.columns[start_].flooded = 1;
  bool met = false;
  for (std::size_t i = 0; i < flood.size() && flood.size() < most && !met; ++i)
    for (const Move& move : moves_)
    {
      const auto next =
          static_cast<std::uint32_t>(static_cast<std::int32_t>(flood[i]) + move.offset);
      Column& column = look(next);
      if (column.flooded || !(column.factor < kInfinity) || (column.walls & walls_)) continue;
      met = met || column.cost < kInfinity;
      column.flooded = 1;
      flood.push_back(next);
    }
  for (const std::uint32_t index : flood) memory_.columns[index].flooded = 0;
  return !met && flood.size() < most;
}
}  // namespace slalom::search::detail
