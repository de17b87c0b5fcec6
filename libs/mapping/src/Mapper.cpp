// SPDX-License-Identifier: BSD-3-Clause
#include "slalom/mapping/Mapper.h"

#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <mutex>
#include <stdexcept>
#include <string>
#include <vector>

#include "EdtGrid.h"
#include "OctreeRecord.h"
#include "RayMarks.h"
#include "RollingWindow.h"

namespace slalom::mapping
{
namespace
{
using detail::Brick;
using detail::EdtCells;

void require(bool good, const std::string& what)
{
  if (!good) throw std::invalid_argument("[mapping] " + what);
}

void check(const MapperConfig& c)
{
  const auto text = [](double value) { return std::to_string(value); };
  require(c.resolution_m > 0.0, "resolution_m = " + text(c.resolution_m) + " must be positive");
  require(c.update_range_m > c.min_range_m,
          "update_range_m = " + text(c.update_range_m) +
              " must exceed min_range_m = " + text(c.min_range_m));
  require(c.window_xy_m >= 2.0 * c.update_range_m,
          "window_xy_m = " + text(c.window_xy_m) +
              " must be at least twice update_range_m = " + text(c.update_range_m));
  require(c.window_z_m >= 2.0 * c.resolution_m,
          "window_z_m = " + text(c.window_z_m) + " must be at least two voxels");
  require(c.hit >= 0.5 && c.hit < 1.0 && c.miss > 0.0 && c.miss <= 0.5,
          "hit must be in [0.5, 1), miss in (0, 0.5]");
  require(c.clamp_min > 0.0 && c.clamp_min <= 0.5 && c.clamp_max >= 0.5 && c.clamp_max < 1.0,
          "clamp_min must be in (0, 0.5], clamp_max in [0.5, 1)");
  require(
      c.occupied_threshold > c.clamp_min && c.occupied_threshold <= c.clamp_max,
      "occupied_threshold = " + text(c.occupied_threshold) + " must lie in (clamp_min, clamp_max]");
  (void)detail::saturationCells(c.max_distance_m, c.resolution_m);
}

Eigen::Vector3i windowSize(const MapperConfig& c)
{
  constexpr double kMaxCells = 64e6;
  const auto cells = [&](double metres)
  { return Brick::kEdge * std::ceil(metres / c.resolution_m / Brick::kEdge - 1e-9); };
  const double xy = cells(c.window_xy_m), z = cells(c.window_z_m);
  require(xy * xy * z <= kMaxCells, "a window of " + std::to_string(xy * xy * z / 1e6) +
                                        " million voxels is more than the 64 million allowed");
  return {static_cast<int>(xy), static_cast<int>(xy), static_cast<int>(z)};
}

// Arrays of snapshots that nobody holds any more, for the next ones: fresh memory of this size
// would cost more page faults than the transform costs work. Readers may drop a snapshot in any
// thread.
class CellPool
{
 public:
  explicit CellPool(const detail::GridShape& shape) : idle_(std::make_shared<Idle>()), shape_(shape)
  {
  }
  [[nodiscard]] std::shared_ptr<EdtCells> take()
  {
    std::unique_ptr<EdtCells> cells;
    {
      const std::lock_guard lock(idle_->mutex);
      if (!idle_->cells.empty())
      {
        cells = std::move(idle_->cells.back());
        idle_->cells.pop_back();
      }
    }
    if (!cells)
    {
      cells = std::make_unique<EdtCells>();
      cells->resize(shape_);
    }
    return {cells.release(), [idle = idle_](EdtCells* used)
            {
              std::unique_ptr<EdtCells> owned(used);
              const std::lock_guard lock(idle->mutex);
              if (idle->cells.size() < kKept) idle->cells.push_back(std::move(owned));
            }};
  }

 private:
  static constexpr std::size_t kKept = 3;
  struct Idle
  {
    std::mutex mutex;
    std::vector<std::unique_ptr<EdtCells>> cells;
  };
  std::shared_ptr<Idle> idle_;
  detail::GridShape shape_;
};

/// Copies a window; unknown cells with a free one at most `reach` cells above or below, and nothing
/// occupied in between, become free.
void bridge(const detail::GridShape& shape, int reach, const std::uint8_t* from, std::uint8_t* to)
{
  static_assert(static_cast<int>(core::Occupancy::Unknown) == 0 &&
                static_cast<int>(core::Occupancy::Free) == 1);
  // Eight cells at a time, one per byte; a class needs two bits. Rows are padded with unknown
  // cells.
  using Eight = std::uint64_t;
  constexpr Eight kLow = 0x0101010101010101u;
  const auto load = [](const std::uint8_t* cells)
  {
    Eight eight;
    std::memcpy(&eight, cells, sizeof eight);
    return eight;
  };
  for (int z = 0; z < shape.size.z(); ++z)
  {
    const int below = std::max(0, z - reach), above = std::min(shape.size.z() - 1, z + reach);
    for (int y = 0; y < shape.size.y(); ++y)
      for (int x = 0; x < shape.pitch(); x += static_cast<int>(sizeof(Eight)))
      {
        Eight free = 0;
        for (const int step : {-1, 1})
        {
          Eight open = kLow;  // nothing occupied in between
          for (int other = z + step; other >= below && other <= above; other += step)
          {
            const Eight there = load(from + shape.row(y, other) + x);
            free |= there & ~(there >> 1) & open;
            open &= ~(there >> 1);
          }
        }
        const Eight here = load(from + shape.row(y, z) + x);
        const Eight bridged = here | (~(here | here >> 1) & free & kLow);
        std::memcpy(to + shape.row(y, z) + x, &bridged, sizeof bridged);
      }
  }
}

double secondsSince(std::chrono::steady_clock::time_point start)
{
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

}  // namespace

struct Mapper::Impl
{
  explicit Impl(const MapperConfig& c)
      : config((check(c), c)),
        record(c.resolution_m, c.occupied_threshold),
        window(windowSize(c), detail::LogOddsModel(c), c.forget_s,
               c.keep_octree ? &record : nullptr),
        marks(window.shape().size, c.resolution_m, c.min_range_m, c.update_range_m),
        transform(window.shape(), detail::saturationCells(c.max_distance_m, c.resolution_m)),
        pool(window.shape()),
        seen(window.shape().cells()),
        metres(EdtSnapshot::Grid::metresTable(c.max_distance_m, c.resolution_m))
  {
  }
  // The window points to the record.
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  MapUpdate integrate(double t, const Eigen::Vector3d& p_L, std::span<const core::Ray> rays,
                      const MoverMask& movers);
  void publish(bool cells_changed);

  MapperConfig config;
  detail::OctreeRecord record;
  detail::RollingWindow window;
  detail::RayMarks marks;
  detail::DistanceTransform transform;
  CellPool pool;
  std::vector<std::uint8_t> seen;  // the window's classes before bridging
  std::shared_ptr<const std::vector<double>> metres;
  std::shared_ptr<const EdtCells> cells;  // of the newest snapshot
  std::shared_ptr<const EdtSnapshot> newest;
  std::uint64_t sequence = 0;
  double stamp = 0.0;
};

MapUpdate Mapper::Impl::integrate(double t, const Eigen::Vector3d& p_L,
                                  std::span<const core::Ray> rays, const MoverMask& movers)
{
  MapUpdate update;
  const double far = 1e9 * config.resolution_m;  // cells that fit an int
  if (!std::isfinite(t) || !(p_L.cwiseAbs().maxCoeff<Eigen::PropagateNaN>() < far)) return update;

  const auto started = std::chrono::steady_clock::now();
  const Eigen::Vector3d p_cells = p_L / config.resolution_m;
  const bool first = newest == nullptr;
  const bool moved = window.centreOn(p_cells.array().floor().cast<int>(), t);
  for (const core::Sphere& ghost : movers.ghosts)
    if (ghost.centre_L.cwiseAbs().maxCoeff<Eigen::PropagateNaN>() < far &&
        ghost.radius_m < config.window_xy_m)
      update.cells_changed += window.forgetBall(ghost.centre_L / config.resolution_m,
                                                ghost.radius_m / config.resolution_m);
  const detail::RayMarks::Count count = marks.cast(window.firstCell(), rays, movers.on_mover);
  update.rays = count.fused;
  update.rays_on_movers = count.free_only;
  update.rays_out_of_range = count.beyond_range;
  if (count.fused + count.beyond_range + count.free_only > 0)
  {
    update.cells_changed += window.fuse(marks, t);
    stamp = t;
  }
  if (first)
    update.cells_changed += window.clearBall(p_cells, config.start_ball_m / config.resolution_m, t);
  update.cells_changed += window.forget(t);
  record.crop(window.firstCell() + window.shape().size / 2,
              static_cast<std::size_t>(config.max_octree_mb * 1e6));
  update.integrate_s = secondsSince(started);

  const auto transform_started = std::chrono::steady_clock::now();
  publish(first || moved || update.cells_changed > 0);
  update.transform_s = secondsSince(transform_started);
  return update;
}

void Mapper::Impl::publish(bool cells_changed)
{
  if (cells_changed)
  {
    const std::shared_ptr<EdtCells> next = pool.take();
    window.copyOccupancy(seen.data());
    bridge(window.shape(), static_cast<int>(std::lround(config.bridge_m / config.resolution_m)),
           seen.data(), next->occupancy.data());
    transform.run(next->occupancy.data(), next->optimistic.data(), next->pessimistic.data());
    cells = next;
  }
  auto grid = std::make_shared<EdtSnapshot::Grid>();
  grid->shape = window.shape();
  grid->origin_L = config.resolution_m * window.firstCell().cast<double>();
  grid->resolution = config.resolution_m;
  grid->max_distance = config.max_distance_m;
  grid->stamp = stamp;
  grid->sequence = ++sequence;
  grid->cells = cells;
  grid->metres = metres;
  newest = std::make_shared<EdtSnapshot>(std::move(grid));
}

Mapper::Mapper(const MapperConfig& config) : impl_(std::make_unique<Impl>(config)) {}
Mapper::~Mapper() = default;
Mapper::Mapper(Mapper&&) noexcept = default;
Mapper& Mapper::operator=(Mapper&&) noexcept = default;

MapUpdate Mapper::integrate(double t, const Eigen::Vector3d& p_L, std::span<const core::Ray> rays,
                            const MoverMask& movers)
{
  return impl_->integrate(t, p_L, rays, movers);
}

std::shared_ptr<const EdtSnapshot> Mapper::snapshot() const
{
  return impl_->newest;
}

void Mapper::reset()
{
  const std::uint64_t sequence = impl_->sequence;  // goes on, so that no two snapshots share one
  impl_ = std::make_unique<Impl>(MapperConfig(impl_->config));
  impl_->sequence = sequence;
}

bool Mapper::writeOctree(const std::filesystem::path& file) const
{
  if (!impl_->config.keep_octree) return false;
  return impl_->record.writeFile(file, [this](const detail::OctreeRecord::BrickSink& sink)
                                 { impl_->window.changedBricks(sink); });
}

std::size_t Mapper::memoryBytes() const
{
  return impl_->window.bytes() + impl_->marks.bytes() + impl_->record.bytes();
}

}  // namespace slalom::mapping
