// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <unordered_map>

#include "Brick.h"

namespace slalom::mapping::detail
{
/** The OctoMap of record, bounded in memory.
 *
 *  It is kept as OcTrees of 32 x 32 x 32 cells each, all with the keys of the one tree that
 * writeFile() joins them to: forgetting a far region then means dropping a tile, which takes no
 * time that a control loop would notice, whereas a single OcTree would have to be rebuilt (its
 * deleteNode() aborts in OctoMap 1.9.7). */
class OctreeRecord
{
 public:
  /// @param occupied_threshold probability from which writeFile() calls a cell occupied
  OctreeRecord(double resolution, double occupied_threshold);
  ~OctreeRecord();

  /** Stores the known cells of a brick; unknown ones keep what is recorded.
   *  @param at brick coordinates: cell coordinates / 4. Ignored beyond the octree's 16-bit keys. */
  void write(const Eigen::Vector3i& at, const Brick& brick);

  /// Removes cells of a brick (bits as in Brick::known): as if they had never been seen.
  void erase(const Eigen::Vector3i& at, std::uint64_t cells);

  /// What is recorded of a brick.
  [[nodiscard]] Brick read(const Eigen::Vector3i& at) const;

  /// Drops the tiles farthest from a cell until bytes() <= max_bytes.
  void crop(const Eigen::Vector3i& around_cell, std::size_t max_bytes);

  /** Writes everything as one maximum-likelihood .bt, atomically.
   *  @param newer calls its argument with the bricks that are newer than the record
   *  @return false if the file cannot be written */
  using BrickSink = std::function<void(const Eigen::Vector3i& at, const Brick& brick)>;
  [[nodiscard]] bool writeFile(const std::filesystem::path& file,
                               const std::function<void(const BrickSink&)>& newer) const;

  [[nodiscard]] std::size_t bytes() const { return bytes_; }  ///< heap of all nodes

 private:
  struct Tile;
  double resolution_;
  double occupied_threshold_;
  std::size_t bytes_ = 0;
  std::unordered_map<std::uint64_t, std::unique_ptr<Tile>> tiles_;
};

}  // namespace slalom::mapping::detail
