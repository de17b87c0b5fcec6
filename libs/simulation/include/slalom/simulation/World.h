// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <vector>

#include "slalom/simulation/Movers.h"
#include "slalom/simulation/Shapes.h"

namespace slalom::simulation
{
/// What a world of primitives is made of.
struct Shapes
{
  std::vector<Tree> trees;  ///< and all other upright cylinders
  std::vector<Box> boxes;
  std::vector<Sphere> spheres;
  std::vector<Mover> movers;
  bool ground = true;
};

/** Solid geometry with exact queries: trees from csv (`x,y,radius,height`, standing on z = 0),
 * boxes and trees from ini, occupied leaves of an octree (.bt/.ot). Shells that enclose unknown
 * space are filled: a hollow trunk is never free. There is a ground plane at z = 0 for csv and ini
 * worlds (key `ground = true`). Immutable, thread-safe.
 *
 *  An ini world has sections `[tree.NAME]` (x, y, radius, height), `[cylinder.NAME]` (the same and
 * base, the height of its foot), `[box.NAME]` (min, max as `x,y,z`), `[sphere.NAME]` (centre,
 * radius), `[mover.NAME]` (Movers.h; libs/simulation/README.md lists its keys) and `[world]`
 * (ground).
 *
 *  castRay(), distance() and bounds() are about what stands still; what moves is asked of movers()
 * at a time.
 *  @throws std::runtime_error naming file, line and value on malformed input */
class World
{
 public:
  /// @param seed of where each mover with `jitter_s` begins
  [[nodiscard]] static World load(const std::filesystem::path& file, std::uint64_t seed = 0);
  /// A world of primitives made in memory. @throws std::invalid_argument on a shape without volume
  [[nodiscard]] static World of(Shapes shapes);
  [[nodiscard]] static World of(std::vector<Tree> trees, std::vector<Box> boxes, bool ground);
  ~World();
  World(World&&) noexcept;
  World& operator=(World&&) noexcept;

  /// First solid along a ray, [m] from the origin; nullopt when nothing within max_range. 0 if the
  /// origin is solid. `direction` needs no unit length, only not to be zero.
  [[nodiscard]] std::optional<double> castRay(const Eigen::Vector3d& origin_W,
                                              const Eigen::Vector3d& direction,
                                              double max_range) const;
  /// Distance to the nearest solid [m], negative inside; exact (to the surface of the primitives or
  /// voxels). Where primitives overlap the inside value is that of the deepest one. Infinite in an
  /// empty world. Ground excluded when `with_ground` is false.
  [[nodiscard]] double distance(const Eigen::Vector3d& p_W, bool with_ground = false) const;
  [[nodiscard]] Eigen::AlignedBox3d bounds() const;  ///< of the file, plus a margin of 2 m
  [[nodiscard]] bool hasGround() const;              ///< solid below z = 0
  [[nodiscard]] const std::vector<Mover>& movers() const;

 private:
  World();
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace slalom::simulation
