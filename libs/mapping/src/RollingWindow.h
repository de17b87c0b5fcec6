// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <unordered_map>
#include <utility>
#include <vector>

#include "Brick.h"
#include "LogOdds.h"
#include "OctreeRecord.h"
#include "RayMarks.h"

namespace slalom::mapping::detail
{
/** Dense log-odds of the cells around the vehicle: a write-back cache in front of the octree.
 *
 *  The window moves by whole bricks. A cell's place in memory is its lattice coordinate modulo the
 * window's size, so moving copies nothing: bricks that leave are written to the record (only those
 * that changed), bricks that enter are read from it. Unknown cells hold log-odds 0, which is also
 * where OctoMap starts a new node. */
class RollingWindow
{
 public:
  /// @param size cells per axis, multiples of Brick::kEdge; @param record may be nullptr
  RollingWindow(const Eigen::Vector3i& size, const LogOddsModel& model, double forget_s,
                OctreeRecord* record);

  /// Centres the window on a cell, to within a brick. True if it moved.
  bool centreOn(const Eigen::Vector3i& cell, double t);

  /// Fuses what a scan saw at time t [s] and clears the marks. Returns cells whose class changed.
  int fuse(RayMarks& marks, double t);

  /// Makes unknown cells within `radius` (in cells) of a point free. Returns how many.
  int clearBall(const Eigen::Vector3d& centre_cells, double radius_cells, double t);

  /** Forgets occupied cells whose centres are within `radius` (in cells) of a point, here and in
   * the record. Returns how many. */
  int forgetBall(const Eigen::Vector3d& centre_cells, double radius_cells);

  /// Returns cells unseen since before t - forget_s to unknown. Returns how many.
  int forget(double t);

  /// Copies core::Occupancy of all cells into a grid of shape(), lowest cell first.
  void copyOccupancy(std::uint8_t* to) const;

  /// Visits the bricks that differ from the record.
  void changedBricks(const OctreeRecord::BrickSink& sink) const;

  [[nodiscard]] const GridShape& shape() const { return shape_; }
  [[nodiscard]] const Eigen::Vector3i& firstCell() const { return first_; }
  [[nodiscard]] std::size_t bytes() const;

 private:
  // A piece of a row that is contiguous in the window and in memory.
  struct Span
  {
    int x, count;      // in the window
    std::size_t cell;  // in memory
    std::size_t brick;
  };
  [[nodiscard]] int wrapped(int coordinate, int axis) const;
  [[nodiscard]] std::size_t cellAt(const Eigen::Vector3i& cell) const;
  [[nodiscard]] std::size_t brickAt(const Eigen::Vector3i& brick) const;
  [[nodiscard]] std::size_t rowAt(int y, int z) const;  // number of the row, for oldest_
  template <class Visit>
  void spans(int y, int z, Visit&& visit) const;
  template <class Visit>
  void bricksOutside(const Eigen::Vector3i& first, const Eigen::Vector3i& other,
                     Visit&& visit) const;

  template <class Visit>
  void cellsInBall(const Eigen::Vector3d& centre_cells, double radius_cells, Visit&& visit) const;

  std::pair<int, bool> fuseFour(std::uint32_t marks, std::size_t cell);
  [[nodiscard]] Brick gather(const Eigen::Vector3i& brick) const;
  void store(const Eigen::Vector3i& brick);
  void evict(const Eigen::Vector3i& brick, double t);
  void load(const Eigen::Vector3i& brick, double t);
  void purgeSeen(double t);
  [[nodiscard]] std::uint8_t classOf(float log_odds) const;

  GridShape shape_;
  LogOddsModel model_;
  double forget_s_;
  OctreeRecord* record_;
  bool placed_ = false;
  Eigen::Vector3i first_ = Eigen::Vector3i::Zero();  // lowest cell, a multiple of Brick::kEdge
  std::vector<float> log_odds_;
  std::vector<std::uint8_t> class_;
  std::vector<std::uint8_t> changed_;  // per brick: differs from the record

  // Only if forget_s > 0: when each cell was last seen, the oldest of each row, and the same of
  // bricks that have left (the octree keeps no times).
  std::vector<double> seen_;
  std::vector<double> oldest_;
  struct SeenBrick
  {
    double newest;
    std::array<double, Brick::kCells> seen;
  };
  std::unordered_map<std::uint64_t, SeenBrick> left_;
  double purged_at_ = 0.0;
};

}  // namespace slalom::mapping::detail
