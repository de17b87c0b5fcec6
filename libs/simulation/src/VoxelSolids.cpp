// SPDX-License-Identifier: BSD-3-Clause
#include "VoxelSolids.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace slalom::simulation::detail
{
namespace
{
constexpr std::uint8_t kHasSolid = 1, kHasEmpty = 2;
constexpr std::uint8_t kFarthest = 254;  // leap of voxels with nothing near

/// One raster sweep of the chess board distance transform. Lines come in the order of the sweep;
/// `nearest` is the least value of the lines swept before, at x-1, x, x+1.
template <class LineAt>
void sweep(const Eigen::Vector3i& size, int direction, LineAt lineAt)
{
  const std::size_t width = static_cast<std::size_t>(size.x());
  std::vector<std::uint8_t> nearest(width);
  for (int i = 0; i < size.z(); ++i)
    for (int j = 0; j < size.y(); ++j)
    {
      const int z = direction > 0 ? i : size.z() - 1 - i;
      const int y = direction > 0 ? j : size.y() - 1 - j;
      std::fill(nearest.begin(), nearest.end(), kFarthest);
      const auto take = [&](int yy, int zz)
      {
        if (yy < 0 || yy >= size.y() || zz < 0 || zz >= size.z()) return;
        const std::uint8_t* other = lineAt(yy, zz);
        for (std::size_t x = 0; x < width; ++x) nearest[x] = std::min(nearest[x], other[x]);
        for (std::size_t x = 1; x < width; ++x) nearest[x] = std::min(nearest[x], other[x - 1]);
        for (std::size_t x = 1; x < width; ++x) nearest[x - 1] = std::min(nearest[x - 1], other[x]);
      };
      take(y - direction, z);
      for (int dy = -1; dy <= 1; ++dy) take(y + dy, z - direction);
      std::uint8_t* line = lineAt(y, z);
      int previous = kFarthest;
      for (std::size_t k = 0; k < width; ++k)
      {
        const std::size_t x = direction > 0 ? k : width - 1 - k;
        const int through = std::min<int>(nearest[x], previous) + 1;
        previous = std::min<int>(line[x], std::min<int>(through, kFarthest));
        line[x] = static_cast<std::uint8_t>(previous);
      }
    }
}
}  // namespace

VoxelSolids::VoxelSolids(const VoxelGrid& grid)
    : corner_W_(grid.corner.cast<double>() * grid.resolution),
      size_(grid.size),
      resolution_(grid.resolution)
{
  computeLeaps(grid);
  buildPyramid();
}

void VoxelSolids::computeLeaps(const VoxelGrid& grid)
{
  leap_.resize(grid.voxels.size());
  std::transform(grid.voxels.begin(), grid.voxels.end(), leap_.begin(),
                 [](Voxel v) { return v == Voxel::Solid ? std::uint8_t{0} : kFarthest; });
  const auto lineAt = [this](int y, int z) { return leap_.data() + index({0, y, z}); };
  sweep(size_, +1, lineAt);
  sweep(size_, -1, lineAt);
}

std::uint8_t VoxelSolids::flagsAt(std::size_t level, const Eigen::Vector3i& cell) const
{
  if (level == 0) return leap_[index(cell)] == 0 ? kHasSolid : kHasEmpty;
  const Level& l = pyramid_[level - 1];
  return l.flags[(static_cast<std::size_t>(cell.z()) * static_cast<std::size_t>(l.size.y()) +
                  static_cast<std::size_t>(cell.y())) *
                     static_cast<std::size_t>(l.size.x()) +
                 static_cast<std::size_t>(cell.x())];
}

void VoxelSolids::buildPyramid()
{
  Eigen::Vector3i below = size_;
  for (std::size_t level = 0; below.maxCoeff() > 1; ++level)
  {
    Level next;
    next.size = (below.array() + 1) / 2;
    next.flags.reserve(static_cast<std::size_t>(next.size.cast<std::int64_t>().prod()));
    for (int z = 0; z < next.size.z(); ++z)
      for (int y = 0; y < next.size.y(); ++y)
        for (int x = 0; x < next.size.x(); ++x)
        {
          std::uint8_t flags = 0;
          for (int child = 0; child < 8; ++child)
          {
            const Eigen::Vector3i c(2 * x + (child & 1), 2 * y + ((child >> 1) & 1),
                                    2 * z + (child >> 2));
            if ((c.array() < below.array()).all()) flags |= flagsAt(level, c);
          }
          next.flags.push_back(flags);
        }
    below = next.size;
    pyramid_.push_back(std::move(next));
  }
}

std::optional<double> VoxelSolids::castRay(const Eigen::Vector3d& origin,
                                           const Eigen::Vector3d& direction, double max_range) const
{
  // In units of voxels, so that borders are whole numbers.
  const double scale = 1.0 / resolution_;
  const Eigen::Vector3d o = (origin - corner_W_) * scale;
  Interval inside{0.0, max_range * scale};
  for (int i = 0; i < 3; ++i) inside = slab(o[i], direction[i], 0.0, size_[i], inside);
  if (inside.enter > inside.leave) return std::nullopt;

  int cell[3], forward[3];
  double inverse[3];
  for (int i = 0; i < 3; ++i)
  {
    cell[i] = std::clamp(static_cast<int>(o[i] + inside.enter * direction[i]), 0, size_[i] - 1);
    // An axis along which the ray does not move never has the nearest border.
    inverse[i] = direction[i] == 0.0 ? std::numeric_limits<double>::infinity() : 1.0 / direction[i];
    forward[i] = direction[i] > 0.0 ? 1 : 0;
  }
  double t = inside.enter;
  while (true)
  {
    const int leap = leap_[index({cell[0], cell[1], cell[2]})];
    if (leap == 0) return t * resolution_;
    // The cube of voxels nearer than `leap` is empty: go to where the ray leaves it.
    int low[3], high[3], axis = 0;
    double leave = std::numeric_limits<double>::infinity();
    for (int i = 0; i < 3; ++i)
    {
      low[i] = cell[i] - leap + 1;
      high[i] = cell[i] + leap - 1;
      const double at = ((forward[i] ? high[i] + 1 : low[i]) - o[i]) * inverse[i];
      if (at < leave && direction[i] != 0.0)
      {
        leave = at;
        axis = i;
      }
    }
    t = std::max(t, leave);
    if (t > inside.leave) return std::nullopt;
    // Truncation rounds towards zero, which matters only where clamping mends it.
    for (int i = 0; i < 3; ++i)
      cell[i] = std::clamp(static_cast<int>(o[i] + t * direction[i]), low[i], high[i]);
    cell[axis] = forward[axis] ? high[axis] + 1 : low[axis] - 1;
    for (int i = 0; i < 3; ++i)
      if (static_cast<unsigned>(cell[i]) >= static_cast<unsigned>(size_[i])) return std::nullopt;
  }
}

struct VoxelSolids::Search
{
  Eigen::Vector3d p;    // [voxels]
  std::uint8_t wanted;  // flag of what is looked for
  double best;          // squared distance [voxels^2]
};

void VoxelSolids::descend(std::size_t level, const Eigen::Vector3i& cell, Search& search) const
{
  struct Child
  {
    double squared;
    Eigen::Vector3i cell;
  };
  std::array<Child, 8> children;
  std::size_t count = 0;
  const double edge = static_cast<double>(1 << level);
  const Eigen::Vector3i limit = level == 0 ? size_ : pyramid_[level - 1].size;
  for (int k = 0; k < 8; ++k)
  {
    const Eigen::Vector3i c(2 * cell.x() + (k & 1), 2 * cell.y() + ((k >> 1) & 1),
                            2 * cell.z() + (k >> 2));
    if ((c.array() >= limit.array()).any() || !(flagsAt(level, c) & search.wanted)) continue;
    const Eigen::Vector3d lo = c.cast<double>() * edge;
    const Eigen::Vector3d out =
        (lo - search.p)
            .cwiseMax((search.p - lo).array().matrix() - Eigen::Vector3d::Constant(edge));
    const double squared = out.cwiseMax(0.0).squaredNorm();
    if (squared >= search.best) continue;
    std::size_t at = count++;
    for (; at > 0 && children[at - 1].squared > squared; --at) children[at] = children[at - 1];
    children[at] = {squared, c};
  }
  for (std::size_t k = 0; k < count && children[k].squared < search.best; ++k)
  {
    if (level == 0)
      search.best = children[k].squared;
    else
      descend(level - 1, children[k].cell, search);
  }
}

double VoxelSolids::distance(const Eigen::Vector3d& p) const
{
  Search search{(p - corner_W_) / resolution_, kHasSolid, std::numeric_limits<double>::infinity()};
  const Eigen::Vector3i cell = search.p.array().floor().max(-1.0).min(1e9).cast<int>();
  const bool within = (cell.array() >= 0).all() && (cell.array() < size_.array()).all();
  const bool solid = within && leap_[index(cell)] == 0;
  if (solid) search.wanted = kHasEmpty;
  // The padding makes sure that there is an empty voxel, and rasterize() that there is a solid one.
  descend(pyramid_.size() - 1, Eigen::Vector3i::Zero(), search);
  const double distance = std::sqrt(search.best) * resolution_;
  return solid ? -distance : distance;
}

Eigen::AlignedBox3d VoxelSolids::bounds() const
{
  const Eigen::Vector3d padding = Eigen::Vector3d::Constant(kPadding * resolution_);
  return {corner_W_ + padding, corner_W_ + size_.cast<double>() * resolution_ - padding};
}

}  // namespace slalom::simulation::detail
