// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "Solids.h"
#include "slalom/simulation/Shapes.h"

namespace slalom::simulation::detail
{
/** Vertical cylinders, boxes and spheres in a uniform horizontal grid: each cell lists the shapes
 * whose footprint touches it, so a ray visits only what stands along its shadow. */
class PrimitiveSolids : public Solids
{
 public:
  PrimitiveSolids(std::vector<Tree> trees, std::vector<Box> boxes, std::vector<Sphere> spheres);

  [[nodiscard]] std::optional<double> castRay(const Eigen::Vector3d& origin,
                                              const Eigen::Vector3d& direction,
                                              double max_range) const override;
  [[nodiscard]] double distance(const Eigen::Vector3d& p) const override;
  [[nodiscard]] Eigen::AlignedBox3d bounds() const override { return bounds_; }

 private:
  struct Ray;
  void buildGrid();
  [[nodiscard]] Eigen::AlignedBox2d footprint(std::size_t shape) const;
  [[nodiscard]] std::size_t cell(int x, int y) const
  {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(size_x_) +
           static_cast<std::size_t>(x);
  }
  [[nodiscard]] std::size_t shapes() const
  {
    return trees_.size() + boxes_.size() + spheres_.size();
  }
  [[nodiscard]] int clampedX(double x) const;
  [[nodiscard]] int clampedY(double y) const;
  [[nodiscard]] double hit(std::size_t shape, const Ray& ray, double best) const;
  [[nodiscard]] double shapeDistance(std::size_t shape, const Eigen::Vector3d& p) const;
  [[nodiscard]] double nearestInCell(int x, int y, const Eigen::Vector3d& p, double best) const;

  std::vector<Tree> trees_;      // the first shapes
  std::vector<Box> boxes_;       // the next
  std::vector<Sphere> spheres_;  // the last
  Eigen::AlignedBox3d bounds_;
  int size_x_ = 0, size_y_ = 0;
  double edge_ = 1.0;                 // of a grid cell [m]
  std::vector<std::uint32_t> first_;  // of each cell in shapes_; one more at the end
  std::vector<std::uint32_t> shapes_;
};

}  // namespace slalom::simulation::detail
