// SPDX-License-Identifier: BSD-3-Clause
#include "slalom/mapping/EdtSnapshot.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <stdexcept>
#include <string>

#include "EdtGrid.h"
#include "HullDistance.h"

namespace slalom::mapping
{
namespace detail
{
void EdtCells::resize(const GridShape& shape)
{
  occupancy.resize(shape.cells());
  optimistic.resize(shape.cells());
  pessimistic.resize(shape.cells());
}

int saturationCells(double max_distance, double resolution)
{
  const double cells = max_distance / resolution + 0.5;
  if (!(max_distance > 0.0 && resolution > 0.0 &&
        cells * cells <= DistanceTransform::kMaxSaturation))
    throw std::invalid_argument(
        "max_distance_m / resolution_m = " + std::to_string(max_distance / resolution) +
        " cells must be in (0, " + std::to_string(std::sqrt(DistanceTransform::kMaxSaturation)) +
        "]");
  return static_cast<int>(std::ceil(cells * cells));
}

}  // namespace detail

namespace
{
using core::Occupancy;

// The eight cells around a query and their trilinear weights.
struct Stencil
{
  std::array<std::size_t, 8> cells;
  Eigen::Vector3d t;  // position between the lower and the upper centres, in [0, 1]

  [[nodiscard]] double weight(int corner) const
  {
    return ((corner & 1) ? t.x() : 1.0 - t.x()) * ((corner & 2) ? t.y() : 1.0 - t.y()) *
           ((corner & 4) ? t.z() : 1.0 - t.z());
  }
};

Eigen::AlignedBox3d boundsOf(const EdtSnapshot::Grid& grid)
{
  const Eigen::Vector3d half = Eigen::Vector3d::Constant(0.5 * grid.resolution);
  return {grid.origin_L + half,
          grid.origin_L + grid.resolution * grid.shape.size.cast<double>() - half};
}

std::optional<Stencil> stencilAt(const EdtSnapshot::Grid& grid, const Eigen::Vector3d& p_L)
{
  if (!boundsOf(grid).contains(p_L)) return std::nullopt;
  const Eigen::Vector3d u = ((p_L - grid.origin_L) / grid.resolution).array() - 0.5;
  Stencil stencil;
  std::array<int, 3> low;
  for (int axis = 0; axis < 3; ++axis)
  {
    low[axis] = std::clamp(static_cast<int>(std::floor(u[axis])), 0, grid.shape.size[axis] - 2);
    stencil.t[axis] = std::clamp(u[axis] - low[axis], 0.0, 1.0);
  }
  for (int corner = 0; corner < 8; ++corner)
    stencil.cells[corner] = grid.shape.row(low[1] + ((corner >> 1) & 1), low[2] + (corner >> 2)) +
                            low[0] + (corner & 1);
  return stencil;
}

const std::int16_t* fieldOf(const EdtSnapshot::Grid& grid, core::UnknownAs unknown)
{
  return unknown == core::UnknownAs::Free ? grid.cells->optimistic.data()
                                          : grid.cells->pessimistic.data();
}

core::DistanceSample interpolate(const EdtSnapshot::Grid& grid, const Stencil& stencil,
                                 const std::int16_t* field)
{
  std::array<double, 8> d;
  for (int corner = 0; corner < 8; ++corner)
  {
    const int squared = field[stencil.cells[corner]];
    const double metres = (*grid.metres)[std::abs(squared)];
    d[corner] = squared < 0 ? -metres : metres;
  }
  const auto mix = [](double a, double b, double t) { return a + t * (b - a); };
  const Eigen::Vector3d& t = stencil.t;
  std::array<double, 4> x, x_slope;  // along x, for the four (y, z) edges
  for (int edge = 0; edge < 4; ++edge)
  {
    x[edge] = mix(d[2 * edge], d[2 * edge + 1], t.x());
    x_slope[edge] = d[2 * edge + 1] - d[2 * edge];
  }
  const double low = mix(x[0], x[1], t.y()), high = mix(x[2], x[3], t.y());
  core::DistanceSample sample;
  sample.distance = mix(low, high, t.z());
  sample.gradient = Eigen::Vector3d(mix(mix(x_slope[0], x_slope[1], t.y()),
                                        mix(x_slope[2], x_slope[3], t.y()), t.z()),
                                    mix(x[1] - x[0], x[3] - x[2], t.z()), high - low) /
                    grid.resolution;
  return sample;
}

// Stored squared distances from this value on are cut off.
int saturationOf(const EdtSnapshot::Grid& grid)
{
  return static_cast<int>(grid.metres->size()) - 1;
}

// Throws unless the grid can be interpolated.
void check(const EdtSnapshot::Grid& grid)
{
  if (grid.shape.size.minCoeff() < 2)
    throw std::invalid_argument("EdtSnapshot: every edge needs at least 2 cells to interpolate");
  if (!grid.origin_L.allFinite()) throw std::invalid_argument("EdtSnapshot: origin is not finite");
}

}  // namespace

std::shared_ptr<const std::vector<double>> EdtSnapshot::Grid::metresTable(double max_distance,
                                                                          double resolution)
{
  auto table =
      std::make_shared<std::vector<double>>(detail::saturationCells(max_distance, resolution) + 1);
  for (std::size_t squared = 0; squared < table->size(); ++squared)
    (*table)[squared] =
        std::min(max_distance, resolution * (std::sqrt(static_cast<double>(squared)) - 0.5));
  return table;
}

EdtSnapshot::EdtSnapshot(std::shared_ptr<const Grid> grid) : grid_(std::move(grid)) {}

std::shared_ptr<const EdtSnapshot> EdtSnapshot::fromOccupancy(const Eigen::Vector3d& origin_L,
                                                              const Eigen::Vector3i& size,
                                                              double resolution,
                                                              const std::vector<Occupancy>& cells,
                                                              double max_distance, double stamp)
{
  auto grid = std::make_shared<Grid>();
  grid->shape = {size};
  grid->origin_L = origin_L;
  grid->resolution = resolution;
  grid->max_distance = max_distance;
  grid->stamp = stamp;
  grid->metres = Grid::metresTable(max_distance, resolution);
  check(*grid);
  if (cells.size() != static_cast<std::size_t>(size.x()) * size.y() * size.z())
    throw std::invalid_argument("EdtSnapshot: " + std::to_string(cells.size()) +
                                " cells given for another grid size");

  auto arrays = std::make_shared<detail::EdtCells>();
  arrays->resize(grid->shape);
  for (int z = 0; z < size.z(); ++z)
    for (int y = 0; y < size.y(); ++y)
      std::memcpy(arrays->occupancy.data() + grid->shape.row(y, z),
                  cells.data() + (static_cast<std::size_t>(z) * size.y() + y) * size.x(), size.x());
  detail::DistanceTransform(grid->shape, detail::saturationCells(max_distance, resolution))
      .run(arrays->occupancy.data(), arrays->optimistic.data(), arrays->pessimistic.data());
  grid->cells = std::move(arrays);
  return std::make_shared<EdtSnapshot>(std::move(grid));
}

Occupancy EdtSnapshot::occupancy(const Eigen::Vector3d& p_L) const
{
  if (!bounds().contains(p_L)) return Occupancy::Unknown;
  const Eigen::Vector3i cell = ((p_L - grid_->origin_L) / grid_->resolution)
                                   .array()
                                   .floor()
                                   .cast<int>()
                                   .max(0)
                                   .min(grid_->shape.size.array() - 1);
  return static_cast<Occupancy>(
      grid_->cells->occupancy[grid_->shape.row(cell.y(), cell.z()) + cell.x()]);
}

std::optional<core::DistanceSample> EdtSnapshot::sample(const Eigen::Vector3d& p_L,
                                                        core::UnknownAs unknown) const
{
  const std::optional<Stencil> stencil = stencilAt(*grid_, p_L);
  if (!stencil) return std::nullopt;
  return interpolate(*grid_, *stencil, fieldOf(*grid_, unknown));
}

/* Proof of the bound, in voxels. Let c_i be the eight centres around p, w_i >= 0 their trilinear
 * weights (sum 1, sum w_i c_i = p), D_i the stored centre distance of c_i (0 inside obstacles;
 * saturation only lowers it) and o the centre of any obstacle cell, so |c_i - o| >= D_i.
 *
 *  The mean of squares about o splits into the squared distance of the mean and the variance:
 *    sum w_i |c_i - o|^2 = |p - o|^2 + V,   V = sum w_i |c_i - p|^2 = sum_axes t (1 - t) <= 3/4,
 *  hence |p - o| >= sqrt(max(0, sum w_i D_i^2 - V)). Every point of the cell's cube is within
 *  sqrt(3)/2 of o, so the distance from p to the cube is at least
 *    b = sqrt(max(0, sum w_i D_i^2 - V)) - sqrt(3)/2,  and never below 0. Since o was arbitrary, b
 *  holds for all obstacle cells, outside the window too.
 *
 *  Not far below the sample: with m = sum w_i D_i, sum w_i D_i^2 >= m^2, and sqrt(m^2 - V) >=
 *  m - sqrt(V) where m >= sqrt(V). As sample <= m - 1/2, sample - max(0, b) <= sqrt(V) +
 *  sqrt(3)/2 - 1/2 <= sqrt(3) - 1/2 < one voxel diagonal (and if m < sqrt(V), sample < 0.37). */
std::optional<double> EdtSnapshot::lowerBound(const Eigen::Vector3d& p_L,
                                              core::UnknownAs unknown) const
{
  constexpr double kRounding = 1e-9;  // [m] covers floating point errors of the formula
  const std::optional<Stencil> stencil = stencilAt(*grid_, p_L);
  if (!stencil) return std::nullopt;
  const std::int16_t* field = fieldOf(*grid_, unknown);
  double mean_square = -(stencil->t.array() * (1.0 - stencil->t.array())).sum();
  for (int corner = 0; corner < 8; ++corner)
    mean_square += stencil->weight(corner) * std::max<int>(0, field[stencil->cells[corner]]);
  const double to_cube = std::sqrt(std::max(0.0, mean_square)) - 0.5 * std::sqrt(3.0);
  const double proved = std::max(0.0, grid_->resolution * to_cube - kRounding);
  return std::min(proved, interpolate(*grid_, *stencil, field).distance);
}

double EdtSnapshot::hullBound(const core::Hull4& hull_L, core::UnknownAs unknown,
                              double limit) const
{
  constexpr double kRounding = 1e-9;  // [m] covers floating point errors
  const Grid& grid = *grid_;
  double bound = std::min(limit, 2.0 * grid.resolution * grid.shape.size.cast<double>().sum());
  if (unknown == core::UnknownAs::Occupied)
  {
    const Eigen::AlignedBox3d box = bounds();
    bound = std::min({bound, (hull_L.colwise() - box.min()).minCoeff(),
                      ((-hull_L).colwise() + box.max()).minCoeff()});
  }
  if (!(bound > 0.0)) return std::min(limit, 0.0);
  const core::Hull4 hull = (hull_L.colwise() - grid.origin_L) / grid.resolution;
  const double to_cubes = detail::distanceToCubes(grid.shape, fieldOf(grid, unknown), hull,
                                                  bound / grid.resolution, saturationOf(grid));
  return std::max(0.0, std::min(bound, grid.resolution * to_cubes) - kRounding);
}

void EdtSnapshot::collectObstacles(const Eigen::AlignedBox3d& box_L, core::UnknownAs unknown,
                                   std::vector<Eigen::Vector3d>& centres_L) const
{
  constexpr auto kFree = static_cast<std::uint8_t>(Occupancy::Free);
  constexpr auto kOccupied = static_cast<std::uint8_t>(Occupancy::Occupied);
  // Most cells are none: memchr passes over them much faster than a loop does.
  const auto nextObstacle = [unknown](const std::uint8_t* from, const std::uint8_t* end)
  {
    if (unknown == core::UnknownAs::Occupied)
      return std::find_if(from, end, [](std::uint8_t value) { return value != kFree; });
    const void* found = std::memchr(from, kOccupied, static_cast<std::size_t>(end - from));
    return found ? static_cast<const std::uint8_t*>(found) : end;
  };
  const Grid& grid = *grid_;
  const Eigen::AlignedBox3d inside = box_L.intersection(bounds());
  if (inside.isEmpty()) return;
  // Indices of the first and the last centre inside the box, per axis.
  const Eigen::Array3d low = (inside.min() - grid.origin_L).array() / grid.resolution - 0.5;
  const Eigen::Array3d high = (inside.max() - grid.origin_L).array() / grid.resolution - 0.5;
  const Eigen::Array3i first = low.ceil().cast<int>().max(0);
  const Eigen::Array3i last = high.floor().cast<int>().min(grid.shape.size.array() - 1);
  for (int z = first.z(); z <= last.z(); ++z)
    for (int y = first.y(); y <= last.y(); ++y)
    {
      const std::uint8_t* row = grid.cells->occupancy.data() + grid.shape.row(y, z);
      const std::uint8_t* end = row + last.x() + 1;
      for (const std::uint8_t* at = nextObstacle(row + first.x(), end); at < end;
           at = nextObstacle(at + 1, end))
        centres_L.emplace_back(grid.origin_L +
                               grid.resolution *
                                   Eigen::Vector3d(double(at - row) + 0.5, y + 0.5, z + 0.5));
    }
}

Eigen::AlignedBox3d EdtSnapshot::bounds() const
{
  return boundsOf(*grid_);
}
double EdtSnapshot::resolution() const
{
  return grid_->resolution;
}
double EdtSnapshot::maxDistance() const
{
  return grid_->max_distance;
}
double EdtSnapshot::stamp() const
{
  return grid_->stamp;
}
std::uint64_t EdtSnapshot::sequence() const
{
  return grid_->sequence;
}

}  // namespace slalom::mapping
