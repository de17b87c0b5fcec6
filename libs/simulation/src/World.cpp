// SPDX-License-Identifier: BSD-3-Clause
#include "slalom/simulation/World.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

#include "OctreeFile.h"
#include "PrimitiveSolids.h"
#include "VoxelGrid.h"
#include "VoxelSolids.h"
#include "WorldFile.h"

namespace slalom::simulation
{
struct World::Impl
{
  std::unique_ptr<const detail::Solids> solids;
  std::vector<Mover> movers;
  bool ground = false;
};

namespace
{
std::unique_ptr<const detail::Solids> loadOctree(const std::filesystem::path& file)
{
  const detail::OctreeLeaves tree = detail::readOctree(file);
  try
  {
    detail::VoxelGrid grid = detail::rasterize(tree);
    detail::fillShells(grid);
    return std::make_unique<detail::VoxelSolids>(grid);
  }
  catch (const std::runtime_error& error)
  {
    throw std::runtime_error(file.string() + ": " + error.what());
  }
}

bool isSize(double value)
{
  return value > 0.0 && std::isfinite(value);
}

void check(const Shapes& shapes)
{
  for (const Tree& tree : shapes.trees)
    if (!tree.centre_W.allFinite() || !isSize(tree.radius) || !isSize(tree.height) ||
        !std::isfinite(tree.base))
      throw std::invalid_argument("World: tree with radius " + std::to_string(tree.radius) +
                                  " m, height " + std::to_string(tree.height) + " m");
  for (const Box& box : shapes.boxes)
    if (!box.min().allFinite() || !box.max().allFinite() ||
        !((box.max() - box.min()).minCoeff() > 0.0))
      throw std::invalid_argument("World: box without volume");
  for (const Sphere& sphere : shapes.spheres)
    if (!sphere.centre_W.allFinite() || !isSize(sphere.radius))
      throw std::invalid_argument("World: sphere with radius " + std::to_string(sphere.radius) +
                                  " m");
}
}  // namespace

World::World() : impl_(std::make_unique<Impl>()) {}
World::~World() = default;
World::World(World&&) noexcept = default;
World& World::operator=(World&&) noexcept = default;

World World::load(const std::filesystem::path& file, std::uint64_t seed)
{
  std::string extension = file.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (extension == ".bt" || extension == ".ot")
  {
    World world;
    world.impl_->solids = loadOctree(file);
    return world;
  }
  if (extension != ".csv" && extension != ".ini")
    throw std::runtime_error(file.string() + ": a world is a .bt, .ot, .csv or .ini file, not '" +
                             extension + "'");
  return of(extension == ".csv" ? detail::readTrees(file) : detail::readIniWorld(file, seed));
}

World World::of(std::vector<Tree> trees, std::vector<Box> boxes, bool ground)
{
  return of(Shapes{std::move(trees), std::move(boxes), {}, {}, ground});
}

World World::of(Shapes shapes)
{
  check(shapes);
  World world;
  world.impl_->solids = std::make_unique<detail::PrimitiveSolids>(
      std::move(shapes.trees), std::move(shapes.boxes), std::move(shapes.spheres));
  world.impl_->movers = std::move(shapes.movers);
  world.impl_->ground = shapes.ground;
  return world;
}

std::optional<double> World::castRay(const Eigen::Vector3d& origin_W,
                                     const Eigen::Vector3d& direction, double max_range) const
{
  const Eigen::Vector3d unit = direction.normalized();
  std::optional<double> ground;
  if (impl_->ground)
  {
    if (origin_W.z() < 0.0) return 0.0;
    if (unit.z() < 0.0 && origin_W.z() <= -unit.z() * max_range) ground = -origin_W.z() / unit.z();
  }
  const std::optional<double> solid =
      impl_->solids->castRay(origin_W, unit, ground.value_or(max_range));
  return solid ? solid : ground;
}

double World::distance(const Eigen::Vector3d& p_W, bool with_ground) const
{
  const double solid = impl_->solids->distance(p_W);
  return with_ground && impl_->ground ? std::min(solid, p_W.z()) : solid;
}

Eigen::AlignedBox3d World::bounds() const
{
  constexpr double kMargin = 2.0;  // [m]
  Eigen::AlignedBox3d box = impl_->solids->bounds();
  if (box.isEmpty()) box.extend(Eigen::Vector3d::Zero());
  const Eigen::Vector3d margin = Eigen::Vector3d::Constant(kMargin);
  return {box.min() - margin, box.max() + margin};
}

const std::vector<Mover>& World::movers() const
{
  return impl_->movers;
}

bool World::hasGround() const
{
  return impl_->ground;
}

}  // namespace slalom::simulation
