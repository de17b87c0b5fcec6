// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "slalom/core/PointCloud.h"
#include "slalom/tracking/TrackingConfig.h"

namespace slalom::tracking::detail
{
/// Returns that may be of one compact thing, as seen from one side.
struct Object
{
  Eigen::Vector3d centre_L = Eigen::Vector3d::Zero();  ///< [m] estimate for the whole body
  double half_width_m = 0.0;                           ///< across the line of sight, in the plane
  double half_height_m = 0.0;
  std::span<const std::uint32_t> rays;  ///< indices; valid until the next find()
};

/// The body that shows these returns, if seen from origin_L.
[[nodiscard]] Object fitObject(const Eigen::Vector3f& origin_L, std::span<const core::Ray> rays,
                               std::span<const std::uint32_t> chosen);

/** Share of the rays through the core of an object that go on beyond it: next to nothing for a
 * body, much for leaves and twigs, which may seem to move because other ones are hit each time. */
[[nodiscard]] double transparency(const Eigen::Vector3f& origin_L, std::span<const core::Ray> rays,
                                  const Object& object);

/** Groups the returns of a scan into compact objects; ground and large structure are left out.
 *
 *  A dense grid around the sensor takes the returns. Columns whose returns are flat, and which
 * continue flat for more than the size of an object, are ground. Of the rest, cells that touch
 * (26 neighbours) are one thing. Its memory is reused. */
class ObjectFinder
{
 public:
  explicit ObjectFinder(const TrackingConfig& config);

  [[nodiscard]] const std::vector<Object>& find(const Eigen::Vector3f& origin_L,
                                                std::span<const core::Ray> rays);

 private:
  // A cell of the grid, or a column of cells, that has returns: a node of a union-find forest.
  struct Node
  {
    int at = 0;  // in the grid
    int parent = 0;
    int count = 0;
    int column = 0;             // of a cell
    int first = 0;              // of a root: where its returns start in sorted_
    Eigen::Vector3f low, high;  // box of its returns; of a root: of all returns
    float base = 0.0f;          // of a column: its own lowest return
  };
  void clear();
  void fill(const Eigen::Vector3f& origin_L, std::span<const core::Ray> rays);
  void findGround();
  void joinCells();
  void sortReturns();
  static int rootOf(std::vector<Node>& nodes, int i);
  static void join(std::vector<Node>& nodes, int a, int b);
  static int add(std::vector<Node>& nodes, std::vector<int>& grid, int at,
                 const Eigen::Vector3f& p);
  [[nodiscard]] bool compact(const Node& root) const;

  TrackingConfig config_;
  int size_xy_, size_z_;  // cells per axis, with a border of one that stays empty
  std::vector<int> cell_grid_, column_grid_;  // number of the node, or -1
  std::vector<Node> cells_, columns_;
  std::vector<std::uint8_t> is_ground_;  // per column
  std::vector<std::uint32_t> near_;      // rays that end in the grid, and the cell of each
  std::vector<int> cell_of_;
  std::vector<std::uint32_t> sorted_;
  std::vector<Object> objects_;
};

}  // namespace slalom::tracking::detail
