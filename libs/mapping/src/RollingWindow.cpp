// SPDX-License-Identifier: BSD-3-Clause
#include "RollingWindow.h"

#include <algorithm>
#include <cstring>
#include <limits>

#include "slalom/core/DistanceField.h"

namespace slalom::mapping::detail
{
namespace
{
constexpr std::uint8_t kUnknown = static_cast<std::uint8_t>(core::Occupancy::Unknown);
constexpr std::uint8_t kFree = static_cast<std::uint8_t>(core::Occupancy::Free);
constexpr std::uint8_t kOccupied = static_cast<std::uint8_t>(core::Occupancy::Occupied);
constexpr int kEdge = Brick::kEdge;
constexpr std::uint32_t kSeenByAny = 0x01010101u * RayMarks::kSeen;
constexpr double kNever = std::numeric_limits<double>::infinity();

}  // namespace

RollingWindow::RollingWindow(const Eigen::Vector3i& size, const LogOddsModel& model,
                             double forget_s, OctreeRecord* record)
    : shape_{size},
      model_(model),
      forget_s_(forget_s),
      record_(record),
      log_odds_(shape_.cells(), 0.0f),
      class_(shape_.cells(), kUnknown),
      changed_(static_cast<std::size_t>((size / kEdge).prod()), 0)
{
  if (forget_s_ <= 0.0) return;
  seen_.assign(shape_.cells(), kNever);
  oldest_.assign(static_cast<std::size_t>(size.y()) * size.z(), kNever);
}

int RollingWindow::wrapped(int coordinate, int axis) const
{
  const int n = shape_.size[axis];
  const int rest = coordinate % n;
  return rest < 0 ? rest + n : rest;
}

std::size_t RollingWindow::cellAt(const Eigen::Vector3i& cell) const
{
  return shape_.row(wrapped(cell.y(), 1), wrapped(cell.z(), 2)) + wrapped(cell.x(), 0);
}

std::size_t RollingWindow::brickAt(const Eigen::Vector3i& brick) const
{
  const Eigen::Vector3i n = shape_.size / kEdge;
  const Eigen::Vector3i cell = kEdge * brick;
  const int bx = wrapped(cell.x(), 0) / kEdge, by = wrapped(cell.y(), 1) / kEdge,
            bz = wrapped(cell.z(), 2) / kEdge;
  return (static_cast<std::size_t>(bz) * n.y() + by) * n.x() + bx;
}

std::size_t RollingWindow::rowAt(int y, int z) const
{
  return static_cast<std::size_t>(wrapped(z + first_.z(), 2)) * shape_.size.y() +
         wrapped(y + first_.y(), 1);
}

template <class Visit>
void RollingWindow::spans(int y, int z, Visit&& visit) const
{
  const int nx = shape_.size.x();
  const int px = wrapped(first_.x(), 0), py = wrapped(y + first_.y(), 1),
            pz = wrapped(z + first_.z(), 2);
  const std::size_t row = shape_.row(py, pz);
  const std::size_t bricks =
      (static_cast<std::size_t>(pz / kEdge) * (shape_.size.y() / kEdge) + py / kEdge) *
      (nx / kEdge);
  visit(Span{0, nx - px, row + px, bricks + px / kEdge});
  if (px > 0) visit(Span{nx - px, px, row, bricks});
}

// Bricks of the window at `first` that are not in the window at `other`.
template <class Visit>
void RollingWindow::bricksOutside(const Eigen::Vector3i& first, const Eigen::Vector3i& other,
                                  Visit&& visit) const
{
  const Eigen::Vector3i a = first / kEdge, n = shape_.size / kEdge, d = (other - first) / kEdge;
  const auto kept = [&](int i, int axis) { return i >= d[axis] && i < d[axis] + n[axis]; };
  for (int z = 0; z < n.z(); ++z)
    for (int y = 0; y < n.y(); ++y)
    {
      const bool row_kept = kept(y, 1) && kept(z, 2);
      for (int x = 0; x < n.x(); ++x)
        if (!row_kept || !kept(x, 0)) visit(Eigen::Vector3i(a + Eigen::Vector3i(x, y, z)));
    }
}

bool RollingWindow::centreOn(const Eigen::Vector3i& cell, double t)
{
  const Eigen::Vector3i off = cell - (first_ + shape_.size / 2);
  // More than half a brick, so that a hovering vehicle does not toggle the window.
  constexpr int kHysteresis = kEdge - 1;
  if (placed_ && off.cwiseAbs().maxCoeff() <= kHysteresis) return false;
  Eigen::Vector3i first = first_;
  for (int axis = 0; axis < 3; ++axis)
    if (!placed_ || std::abs(off[axis]) > kHysteresis)
      first[axis] = kEdge * floorDiv(cell[axis] - shape_.size[axis] / 2 + kEdge / 2, kEdge);
  if (placed_) bricksOutside(first_, first, [&](const Eigen::Vector3i& brick) { evict(brick, t); });
  const Eigen::Vector3i old = placed_ ? first_ : Eigen::Vector3i(first + 2 * shape_.size);
  first_ = first;
  placed_ = true;
  bricksOutside(first_, old, [&](const Eigen::Vector3i& brick) { load(brick, t); });
  purgeSeen(t);
  return true;
}

Brick RollingWindow::gather(const Eigen::Vector3i& brick) const
{
  Brick out;
  const std::size_t corner = cellAt(kEdge * brick);
  for (int z = 0; z < kEdge; ++z)
    for (int y = 0; y < kEdge; ++y)
      for (int x = 0; x < kEdge; ++x)
      {
        const std::size_t cell = corner + shape_.row(y, z) + x;
        if (class_[cell] == kUnknown) continue;
        out.known |= std::uint64_t{1} << Brick::index(x, y, z);
        out.log_odds[Brick::index(x, y, z)] = log_odds_[cell];
      }
  return out;
}

void RollingWindow::store(const Eigen::Vector3i& brick)
{
  std::uint8_t& changed = changed_[brickAt(brick)];
  if (record_ != nullptr && changed) record_->write(brick, gather(brick));
  changed = 0;
}

void RollingWindow::evict(const Eigen::Vector3i& brick, double t)
{
  store(brick);
  const std::size_t corner = cellAt(kEdge * brick);
  SeenBrick times{-kNever, {}};
  for (int z = 0; z < kEdge; ++z)
    for (int y = 0; y < kEdge; ++y)
    {
      const std::size_t row = corner + shape_.row(y, z);
      std::fill_n(class_.begin() + row, kEdge, kUnknown);
      std::fill_n(log_odds_.begin() + row, kEdge, 0.0f);
      if (seen_.empty()) continue;
      for (int x = 0; x < kEdge; ++x)
      {
        const double when = std::exchange(seen_[row + x], kNever);
        times.seen[Brick::index(x, y, z)] = when;
        if (when != kNever) times.newest = std::max(times.newest, when);
      }
    }
  if (record_ != nullptr && times.newest > t - forget_s_) left_[packed(brick)] = times;
}

void RollingWindow::load(const Eigen::Vector3i& brick, double t)
{
  if (record_ == nullptr) return;
  const SeenBrick* times = nullptr;
  if (forget_s_ > 0.0)
  {
    const auto found = left_.find(packed(brick));
    if (found == left_.end()) return;
    times = &found->second;
  }
  const Brick stored = record_->read(brick);
  const std::size_t corner = cellAt(kEdge * brick);
  for (int z = 0; z < kEdge && stored.known != 0; ++z)
    for (int y = 0; y < kEdge; ++y)
      for (int x = 0; x < kEdge; ++x)
      {
        const int i = Brick::index(x, y, z);
        if ((stored.known >> i & 1) == 0) continue;
        if (times && !(times->seen[i] != kNever && times->seen[i] > t - forget_s_)) continue;
        const std::size_t cell = corner + shape_.row(y, z) + x;
        log_odds_[cell] = stored.log_odds[i];
        class_[cell] = classOf(stored.log_odds[i]);
        if (!times) continue;
        seen_[cell] = times->seen[i];
        double& oldest =
            oldest_[rowAt(kEdge * brick.y() + y - first_.y(), kEdge * brick.z() + z - first_.z())];
        oldest = std::min(oldest, times->seen[i]);
      }
  if (times) left_.erase(packed(brick));
}

void RollingWindow::purgeSeen(double t)
{
  // Now and then, because it visits all of them.
  if (forget_s_ <= 0.0 || t - purged_at_ < forget_s_) return;
  purged_at_ = t;
  std::erase_if(left_, [&](const auto& entry) { return entry.second.newest <= t - forget_s_; });
}

std::uint8_t RollingWindow::classOf(float log_odds) const
{
  return log_odds >= model_.occupied ? kOccupied : kFree;
}

int RollingWindow::fuse(RayMarks& marks, double t)
{
  marks.clearMargin();
  int changes = 0;
  for (int z = 0; z < shape_.size.z(); ++z)
    for (int y = 0; y < shape_.size.y(); ++y)
    {
      bool touched = false;
      spans(y, z,
            [&](const Span& span)
            {
              std::uint8_t* mark = marks.row(y, z) + span.x;
              for (int x = 0; x < span.count; x += kEdge)
              {
                std::uint32_t four;
                std::memcpy(&four, mark + x, sizeof(four));
                if (four == 0) continue;
                std::memset(mark + x, 0, sizeof(four));
                if ((four & kSeenByAny) == 0) continue;
                const auto [other_class, other_value] = fuseFour(four, span.cell + x);
                changes += other_class;
                changed_[span.brick + x / kEdge] |= other_value;
                touched = true;
                for (int i = 0; i < kEdge && !seen_.empty(); ++i)
                  if ((four >> 8 * i & RayMarks::kSeen) != 0) seen_[span.cell + x + i] = t;
              }
            });
      if (touched && !oldest_.empty()) oldest_[rowAt(y, z)] = std::min(oldest_[rowAt(y, z)], t);
    }
  return changes;
}

// Updates four cells that lie side by side, without branches: whether a cell was seen, hit or has
// changed is as good as random. Returns how many classes changed and whether any value did.
std::pair<int, bool> RollingWindow::fuseFour(std::uint32_t marks, std::size_t cell)
{
  typedef float Reals __attribute__((vector_size(16)));
  typedef std::int32_t Ints __attribute__((vector_size(16)));
  const auto all = [](float value) { return Reals{value, value, value, value}; };
  std::uint8_t* classes = class_.data() + cell;
  const Ints mark = {
      static_cast<std::int32_t>(marks & 255), static_cast<std::int32_t>(marks >> 8 & 255),
      static_cast<std::int32_t>(marks >> 16 & 255), static_cast<std::int32_t>(marks >> 24)};
  const Ints old_class = {classes[0], classes[1], classes[2], classes[3]};
  Reals old_value;
  std::memcpy(&old_value, log_odds_.data() + cell, sizeof(old_value));

  // A hit wins over any number of passes.
  Reals value =
      old_value + ((mark & int{RayMarks::kHit}) != 0 ? all(model_.hit) : all(model_.miss));
  value = value < all(model_.clamp_min) ? all(model_.clamp_min) : value;
  value = value > all(model_.clamp_max) ? all(model_.clamp_max) : value;
  const Ints seen = (mark & int{RayMarks::kSeen}) != 0;
  const Ints occupied = value >= all(model_.occupied);
  value = seen ? value : old_value;
  const Ints of_value = (occupied & int{kOccupied}) | (~occupied & int{kFree});
  const Ints now = seen ? of_value : old_class;
  std::memcpy(log_odds_.data() + cell, &value, sizeof(value));
  int other_class = 0;
  bool other_value = false;
  const Ints differs = value != old_value;
  for (int i = 0; i < kEdge; ++i)
  {
    classes[i] = static_cast<std::uint8_t>(now[i]);
    other_class += now[i] != old_class[i];
    other_value |= differs[i] != 0;
  }
  return {other_class, other_value || other_class > 0};
}

// Cells of the window whose centres lie in a ball.
template <class Visit>
void RollingWindow::cellsInBall(const Eigen::Vector3d& centre_cells, double radius_cells,
                                Visit&& visit) const
{
  const Eigen::Vector3i low = (centre_cells.array() - radius_cells).floor().cast<int>();
  const Eigen::Vector3i high = (centre_cells.array() + radius_cells).floor().cast<int>();
  const Eigen::Vector3i last = first_ + shape_.size - Eigen::Vector3i::Ones();
  for (int z = std::max(low.z(), first_.z()); z <= std::min(high.z(), last.z()); ++z)
    for (int y = std::max(low.y(), first_.y()); y <= std::min(high.y(), last.y()); ++y)
      for (int x = std::max(low.x(), first_.x()); x <= std::min(high.x(), last.x()); ++x)
      {
        const Eigen::Vector3d to_centre = Eigen::Vector3d(x + 0.5, y + 0.5, z + 0.5) - centre_cells;
        if (to_centre.norm() <= radius_cells) visit(Eigen::Vector3i(x, y, z));
      }
}

int RollingWindow::clearBall(const Eigen::Vector3d& centre_cells, double radius_cells, double t)
{
  int changes = 0;
  cellsInBall(centre_cells, radius_cells,
              [&](const Eigen::Vector3i& at)
              {
                const std::size_t cell = cellAt(at);
                if (class_[cell] != kUnknown) return;
                log_odds_[cell] = model_.miss;
                class_[cell] = kFree;
                changed_[brickAt(at.unaryExpr([](int i) { return floorDiv(i, kEdge); }))] = 1;
                ++changes;
                if (seen_.empty()) return;
                seen_[cell] = t;
                double& oldest = oldest_[rowAt(at.y() - first_.y(), at.z() - first_.z())];
                oldest = std::min(oldest, t);
              });
  return changes;
}

int RollingWindow::forgetBall(const Eigen::Vector3d& centre_cells, double radius_cells)
{
  int changes = 0;
  cellsInBall(centre_cells, radius_cells,
              [&](const Eigen::Vector3i& at)
              {
                const std::size_t cell = cellAt(at);
                if (class_[cell] != kOccupied) return;
                log_odds_[cell] = 0.0f;
                class_[cell] = kUnknown;
                if (!seen_.empty()) seen_[cell] = kNever;
                ++changes;
                if (record_ == nullptr) return;
                const Eigen::Vector3i brick =
                    at.unaryExpr([](int i) { return floorDiv(i, kEdge); });
                const Eigen::Vector3i in = at - kEdge * brick;
                record_->erase(brick, std::uint64_t{1} << Brick::index(in.x(), in.y(), in.z()));
              });
  return changes;
}

int RollingWindow::forget(double t)
{
  int changes = 0;
  if (forget_s_ <= 0.0) return changes;
  for (int z = 0; z < shape_.size.z(); ++z)
    for (int y = 0; y < shape_.size.y(); ++y)
    {
      double& oldest = oldest_[rowAt(y, z)];
      if (oldest > t - forget_s_) continue;
      oldest = kNever;
      for (int x = 0; x < shape_.size.x(); ++x)
      {
        const Eigen::Vector3i at = first_ + Eigen::Vector3i(x, y, z);
        const std::size_t cell = cellAt(at);
        if (seen_[cell] > t - forget_s_)
        {
          oldest = std::min(oldest, seen_[cell]);
          continue;
        }
        // The record keeps the last that was known.
        store(at.unaryExpr([](int i) { return floorDiv(i, kEdge); }));
        seen_[cell] = kNever;
        class_[cell] = kUnknown;
        log_odds_[cell] = 0.0f;
        ++changes;
      }
    }
  return changes;
}

void RollingWindow::copyOccupancy(std::uint8_t* to) const
{
  for (int z = 0; z < shape_.size.z(); ++z)
    for (int y = 0; y < shape_.size.y(); ++y)
      spans(y, z,
            [&](const Span& span) {
              std::memcpy(to + shape_.row(y, z) + span.x, class_.data() + span.cell, span.count);
            });
}

void RollingWindow::changedBricks(const OctreeRecord::BrickSink& sink) const
{
  if (!placed_) return;
  bricksOutside(first_, first_ + 2 * shape_.size,
                [&](const Eigen::Vector3i& brick)
                {
                  if (changed_[brickAt(brick)]) sink(brick, gather(brick));
                });
}

std::size_t RollingWindow::bytes() const
{
  return log_odds_.size() * sizeof(float) + class_.size() + changed_.size() +
         (seen_.size() + oldest_.size()) * sizeof(double) + left_.size() * sizeof(SeenBrick);
}

}  // namespace slalom::mapping::detail
