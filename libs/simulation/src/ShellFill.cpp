// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <numbers>

#include "VoxelGrid.h"

namespace slalom::simulation::detail
{
namespace
{
constexpr double kThickestTrunk = 1.5;  // [m] diameter
constexpr double kColumnGap = 0.5;      // [m]

enum class Mark : std::uint8_t
{
  Open,     // not reached yet
  Wall,     // blocks the flood
  Reached,  // outside, or connected with free space
  Hole      // enclosed, small
};

/// One horizontal slice of marks with its floods; 4-connected, so that a ring of voxels that touch
/// at their corners is closed.
class Slice
{
 public:
  explicit Slice(const VoxelGrid& grid)
      : width_(grid.size.x()),
        height_(grid.size.y()),
        max_hole_(static_cast<std::size_t>(std::numbers::pi * 0.25 * kThickestTrunk *
                                           kThickestTrunk / grid.resolution / grid.resolution)),
        marks_(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_))
  {
  }

  std::vector<Mark>& marks() { return marks_; }

  /// Spreads `mark` over the open cells connected with `start`; the cells stay in `visited_`.
  void flood(std::size_t start, Mark mark)
  {
    visited_.assign(1, start);
    marks_[start] = mark;
    for (std::size_t k = 0; k < visited_.size(); ++k)
    {
      const std::size_t c = visited_[k];
      const std::size_t w = static_cast<std::size_t>(width_), x = c % w;
      const auto visit = [&](std::size_t n)
      {
        if (marks_[n] != Mark::Open) return;
        marks_[n] = mark;
        visited_.push_back(n);
      };
      if (x > 0) visit(c - 1);
      if (x + 1 < w) visit(c + 1);
      if (c >= w) visit(c - w);
      if (c + w < marks_.size()) visit(c + w);
    }
  }

  /// Every region that is still open becomes a hole, or counts as reached if it is larger than a
  /// trunk.
  void closeRegions()
  {
    for (std::size_t c = 0; c < marks_.size(); ++c)
    {
      if (marks_[c] != Mark::Open) continue;
      flood(c, Mark::Hole);
      if (visited_.size() <= max_hole_) continue;
      for (const std::size_t n : visited_) marks_[n] = Mark::Reached;
    }
  }

 private:
  int width_, height_;
  std::size_t max_hole_;
  std::vector<Mark> marks_;
  std::vector<std::size_t> visited_;
};

/// Walls of slice z: solid voxels, thickened by one voxel in all 26 directions if asked for.
void drawWalls(const VoxelGrid& grid, int z, bool thick, std::vector<Mark>& marks)
{
  const int w = grid.size.x(), h = grid.size.y();
  std::fill(marks.begin(), marks.end(), Mark::Open);
  const int r = thick ? 1 : 0;
  for (int zz = std::max(0, z - r); zz <= std::min(grid.size.z() - 1, z + r); ++zz)
    for (int y = r; y < h - r; ++y)
      for (int x = r; x < w - r; ++x)
      {
        if (grid.voxels[grid.index(x, y, zz)] != Voxel::Solid) continue;
        for (int dy = -r; dy <= r; ++dy)
          for (int dx = -r; dx <= r; ++dx)
            marks[static_cast<std::size_t>(y + dy) * static_cast<std::size_t>(w) +
                  static_cast<std::size_t>(x + dx)] = Mark::Wall;
      }
}

/// Floods slice z from outside (its corner is empty) and from known free space, closes the holes.
void findHoles(const VoxelGrid& grid, int z, bool thick, Slice& slice)
{
  drawWalls(grid, z, thick, slice.marks());
  slice.flood(0, Mark::Reached);
  const std::size_t first = grid.index(0, 0, z);
  for (std::size_t c = 0; c < slice.marks().size(); ++c)
    if (grid.voxels[first + c] == Voxel::Free && slice.marks()[c] == Mark::Open)
      slice.flood(c, Mark::Reached);
  slice.closeRegions();
}

/// Holes of one slice into `filled`, grown back by the thickness of the walls.
void markFilled(const VoxelGrid& grid, int z, int grow, const std::vector<Mark>& marks,
                std::vector<std::uint8_t>& filled)
{
  const int w = grid.size.x();
  for (std::size_t c = 0; c < marks.size(); ++c)
  {
    if (marks[c] != Mark::Hole) continue;
    const int x = static_cast<int>(c) % w, y = static_cast<int>(c) / w;
    for (int dy = -grow; dy <= grow; ++dy)
      for (int dx = -grow; dx <= grow; ++dx)
      {
        const std::size_t n = grid.index(x + dx, y + dy, z);
        if (grid.voxels[n] == Voxel::Unknown) filled[n] = 1;
      }
  }
}

/// Unknown voxels that no path from outside or from free space reaches (6-connected).
void fillClosed(const VoxelGrid& grid, std::vector<std::uint8_t>& filled)
{
  std::vector<std::uint8_t> reached(grid.voxels.size(), 0);
  std::vector<std::size_t> stack{0};
  reached[0] = 1;
  for (std::size_t c = 0; c < grid.voxels.size(); ++c)
    if (grid.voxels[c] == Voxel::Free)
    {
      reached[c] = 1;
      stack.push_back(c);
    }
  const std::size_t row = static_cast<std::size_t>(grid.size.x());
  const std::size_t layer = row * static_cast<std::size_t>(grid.size.y());
  const auto visit = [&](std::size_t n)
  {
    if (reached[n] || grid.voxels[n] == Voxel::Solid) return;
    reached[n] = 1;
    stack.push_back(n);
  };
  while (!stack.empty())
  {
    const std::size_t c = stack.back();
    stack.pop_back();
    if (c % row > 0) visit(c - 1);
    if (c % row + 1 < row) visit(c + 1);
    if (c % layer >= row) visit(c - row);
    if (c % layer + row < layer) visit(c + row);
    if (c >= layer) visit(c - layer);
    if (c + layer < reached.size()) visit(c + layer);
  }
  for (std::size_t c = 0; c < reached.size(); ++c)
    if (!reached[c] && grid.voxels[c] == Voxel::Unknown) filled[c] = 1;
}

/// Joins filled parts of a column across at most `gap` unknown voxels.
void joinColumns(const VoxelGrid& grid, int gap, std::vector<std::uint8_t>& filled)
{
  const std::size_t layer =
      static_cast<std::size_t>(grid.size.x()) * static_cast<std::size_t>(grid.size.y());
  for (std::size_t column = 0; column < layer; ++column)
  {
    int last = -1;  // z of the newest filled voxel with only unknown ones since
    for (int z = 0; z < grid.size.z(); ++z)
    {
      const std::size_t c = column + layer * static_cast<std::size_t>(z);
      if (grid.voxels[c] != Voxel::Unknown)
        last = -1;
      else if (filled[c])
      {
        if (last >= 0 && z - last - 1 <= gap)
          for (int k = last + 1; k < z; ++k)
            filled[column + layer * static_cast<std::size_t>(k)] = 1;
        last = z;
      }
    }
  }
}
}  // namespace

void fillShells(VoxelGrid& grid)
{
  std::vector<std::uint8_t> filled(grid.voxels.size(), 0);
  fillClosed(grid, filled);
  Slice slice(grid);
  for (int z = kPadding; z < grid.size.z() - kPadding; ++z)
    for (const int thickness : {0, 1})
    {
      findHoles(grid, z, thickness == 1, slice);
      markFilled(grid, z, thickness, slice.marks(), filled);
    }
  joinColumns(grid, static_cast<int>(std::lround(kColumnGap / grid.resolution)), filled);
  for (std::size_t c = 0; c < filled.size(); ++c)
    if (filled[c]) grid.voxels[c] = Voxel::Solid;
}

}  // namespace slalom::simulation::detail
