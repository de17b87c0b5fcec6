// SPDX-License-Identifier: BSD-3-Clause
#include "OctreeRecord.h"

#include <octomap/OcTree.h>

#include <algorithm>
#include <fstream>
#include <iomanip>
#include <system_error>
#include <vector>

namespace slalom::mapping::detail
{
namespace
{
constexpr int kTileBricks = 8;  // per edge
constexpr int kDepth = 16;      // levels of an OcTree
constexpr int kKeyOrigin = 1 << (kDepth - 1);
constexpr int kBrickLevel = 2;  // a brick's node is this far above the leaves

class RecordTree : public octomap::OcTree
{
 public:
  explicit RecordTree(double edge) : octomap::OcTree(edge)
  {
    // Buffers of OctoMap's own ray casting, 600 kB per tree, which a tile never uses.
    keyrays.clear();
    keyrays.shrink_to_fit();
  }

  // Inner nodes are counted because OctoMap can only do so by visiting all of them.
  [[nodiscard]] std::size_t bytes() const
  {
    constexpr std::size_t kNode = 32, kChildren = 80;  // malloc chunks of both allocations
    return sizeof(RecordTree) + tree_size * kNode + inner_ * kChildren;
  }

  void write(const Eigen::Vector3i& at, const Brick& brick)
  {
    const octomap::OcTreeKey key = firstKey(at);
    bool fresh = false;
    if (root == nullptr)
    {
      root = new octomap::OcTreeNode();
      tree_size = 1;
      size_changed = true;
      fresh = true;
    }
    octomap::OcTreeNode* node = root;
    for (int level = kDepth - 1; level >= kBrickLevel; --level)
      node = childOf(node, octomap::computeChildIdx(key, level), fresh);
    if (uniform(brick) && !nodeHasChildren(node))
      node->setLogOdds(brick.log_odds[0]);
    else
      fill(node, kBrickLevel, brick, {0, 0, 0}, fresh);
  }

  void erase(const Eigen::Vector3i& at, std::uint64_t cells)
  {
    if (root != nullptr && eraseBelow(root, kDepth, firstKey(at), cells, {0, 0, 0})) clear();
  }

  [[nodiscard]] Brick read(const Eigen::Vector3i& at) const
  {
    Brick brick;
    if (root == nullptr) return brick;
    const octomap::OcTreeKey key = firstKey(at);
    const octomap::OcTreeNode* node = root;
    for (int level = kDepth - 1; level >= kBrickLevel; --level)
    {
      const unsigned child = octomap::computeChildIdx(key, level);
      if (!nodeHasChildren(node)) break;  // a pruned cube larger than the brick
      if (!nodeChildExists(node, child)) return brick;
      node = getNodeChild(node, child);
    }
    collect(node, kBrickLevel, brick, {0, 0, 0});
    return brick;
  }

 private:
  static octomap::OcTreeKey firstKey(const Eigen::Vector3i& at)
  {
    const Eigen::Vector3i key = at * Brick::kEdge + Eigen::Vector3i::Constant(kKeyOrigin);
    return {static_cast<octomap::key_type>(key.x()), static_cast<octomap::key_type>(key.y()),
            static_cast<octomap::key_type>(key.z())};
  }
  static Eigen::Vector3i cornerOf(const Eigen::Vector3i& low, unsigned child, int level)
  {
    const int half = 1 << (level - 1);
    return low + half * Eigen::Vector3i(child & 1, (child >> 1) & 1, child >> 2);
  }

  // The child, made if it is missing. `fresh` says whether the node, then the child, is new: an old
  // node without children stands for a whole cube of equal cells and has to be split.
  octomap::OcTreeNode* childOf(octomap::OcTreeNode* node, unsigned child, bool& fresh)
  {
    const bool leaf = !nodeHasChildren(node);
    if (leaf) ++inner_;
    if (leaf && !fresh) expandNode(node);
    fresh = !nodeChildExists(node, child);
    return fresh ? createNodeChild(node, child) : getNodeChild(node, child);
  }

  void fill(octomap::OcTreeNode* node, int level, const Brick& brick, const Eigen::Vector3i& low,
            bool fresh)
  {
    if (level == 0)
    {
      node->setLogOdds(brick.log_odds[Brick::index(low.x(), low.y(), low.z())]);
      return;
    }
    for (unsigned child = 0; child < 8; ++child)
    {
      const Eigen::Vector3i corner = cornerOf(low, child, level);
      if (!anyKnown(brick, corner, level - 1)) continue;
      bool child_fresh = fresh;
      octomap::OcTreeNode* next = childOf(node, child, child_fresh);
      fill(next, level - 1, brick, corner, child_fresh);
    }
    node->updateOccupancyChildren();
    if (pruneNode(node)) --inner_;
  }

  // Removes cells below a node, which is `level` levels above the leaves; `low` is its corner in
  // the brick once it is in the brick. True if nothing is left of the node but its own, childless
  // self.
  bool eraseBelow(octomap::OcTreeNode* node, int level, const octomap::OcTreeKey& key,
                  std::uint64_t cells, const Eigen::Vector3i& low)
  {
    if (level == 0) return true;
    if (!nodeHasChildren(node))
    {
      expandNode(node);
      ++inner_;
    }
    const bool in_brick = level <= kBrickLevel;
    for (unsigned child = 0; child < 8; ++child)
    {
      if (!in_brick && child != octomap::computeChildIdx(key, level - 1)) continue;
      const Eigen::Vector3i corner = in_brick ? cornerOf(low, child, level) : low;
      if (in_brick && (cells & cubeBits(corner, level - 1)) == 0) continue;
      if (nodeChildExists(node, child) &&
          eraseBelow(getNodeChild(node, child), level - 1, key, cells, corner))
        deleteNodeChild(node, child);
    }
    if (nodeHasChildren(node))
    {
      if (in_brick) node->updateOccupancyChildren();
      return false;
    }
    // OctoMap frees the array of children only when it prunes, which takes eight equal ones.
    for (unsigned child = 0; child < 8; ++child) createNodeChild(node, child);
    pruneNode(node);
    --inner_;
    return true;
  }

  static bool uniform(const Brick& brick)
  {
    return ~brick.known == 0 &&
           std::all_of(brick.log_odds.begin(), brick.log_odds.end(),
                       [&brick](float value) { return value == brick.log_odds[0]; });
  }

  static bool anyKnown(const Brick& brick, const Eigen::Vector3i& low, int level)
  {
    return (brick.known & cubeBits(low, level)) != 0;
  }

  // Bits of the cells of a cube of 1 or 2 cells per edge.
  static std::uint64_t cubeBits(const Eigen::Vector3i& low, int level)
  {
    const std::uint64_t cube = level == 0 ? 1u : 0x0000000000330033u;
    return cube << Brick::index(low.x(), low.y(), low.z());
  }

  void collect(const octomap::OcTreeNode* node, int level, Brick& brick,
               const Eigen::Vector3i& low) const
  {
    if (!nodeHasChildren(node))
    {
      const int edge = 1 << level;
      for (int z = low.z(); z < low.z() + edge; ++z)
        for (int y = low.y(); y < low.y() + edge; ++y)
          for (int x = low.x(); x < low.x() + edge; ++x)
          {
            brick.known |= std::uint64_t{1} << Brick::index(x, y, z);
            brick.log_odds[Brick::index(x, y, z)] = node->getLogOdds();
          }
      return;
    }
    for (unsigned child = 0; child < 8; ++child)
      if (nodeChildExists(node, child))
        collect(getNodeChild(node, child), level - 1, brick, cornerOf(low, child, level));
  }

  std::size_t inner_ = 0;
};

Eigen::Vector3i tileOf(const Eigen::Vector3i& brick)
{
  return brick.unaryExpr([](int i) { return floorDiv(i, kTileBricks); });
}

bool representable(const Eigen::Vector3i& brick)
{
  constexpr int kLimit = kKeyOrigin / Brick::kEdge;
  return brick.minCoeff() >= -kLimit && brick.maxCoeff() < kLimit;
}

// The .bt format. OctoMap's own writeBinary() would announce itself on the terminal.
void writeBinaryTree(std::ostream& stream, octomap::OcTree& tree)
{
  tree.toMaxLikelihood();
  tree.prune();
  stream << "# Octomap OcTree binary file\nid OcTree\nsize " << tree.size() << "\nres "
         << std::setprecision(17) << tree.getResolution() << "\ndata\n";
  if (tree.getRoot() != nullptr) tree.writeBinaryData(stream);
}

// A file under a temporary name becomes visible only when it is complete.
bool writeAtomically(const std::filesystem::path& file, octomap::OcTree& tree)
{
  std::filesystem::path temporary = file;
  temporary += ".part";
  std::ofstream stream(temporary, std::ios::binary | std::ios::trunc);
  if (!stream) return false;
  writeBinaryTree(stream, tree);
  stream.close();
  std::error_code error;
  if (!stream.fail()) std::filesystem::rename(temporary, file, error);
  if (!stream.fail() && !error) return true;
  std::filesystem::remove(temporary, error);
  return false;
}

}  // namespace

struct OctreeRecord::Tile
{
  Tile(const Eigen::Vector3i& position, double resolution) : at(position), tree(resolution) {}

  Eigen::Vector3i at;
  RecordTree tree;
};

OctreeRecord::OctreeRecord(double resolution, double occupied_threshold)
    : resolution_(resolution), occupied_threshold_(occupied_threshold)
{
}
OctreeRecord::~OctreeRecord() = default;

void OctreeRecord::write(const Eigen::Vector3i& at, const Brick& brick)
{
  if (brick.known == 0 || !representable(at)) return;
  const Eigen::Vector3i tile_at = tileOf(at);
  std::unique_ptr<Tile>& tile = tiles_[packed(tile_at)];
  if (!tile)
    tile = std::make_unique<Tile>(tile_at, resolution_);
  else
    bytes_ -= tile->tree.bytes();
  tile->tree.write(at, brick);
  bytes_ += tile->tree.bytes();
}

void OctreeRecord::erase(const Eigen::Vector3i& at, std::uint64_t cells)
{
  const auto tile = representable(at) ? tiles_.find(packed(tileOf(at))) : tiles_.end();
  if (tile == tiles_.end() || (tile->second->tree.read(at).known & cells) == 0) return;
  bytes_ -= tile->second->tree.bytes();
  tile->second->tree.erase(at, cells);
  bytes_ += tile->second->tree.bytes();
}

Brick OctreeRecord::read(const Eigen::Vector3i& at) const
{
  const auto tile = representable(at) ? tiles_.find(packed(tileOf(at))) : tiles_.end();
  return tile == tiles_.end() ? Brick{} : tile->second->tree.read(at);
}

void OctreeRecord::crop(const Eigen::Vector3i& around_cell, std::size_t max_bytes)
{
  constexpr int kTileCells = kTileBricks * Brick::kEdge;
  while (bytes_ > max_bytes && !tiles_.empty())
  {
    // Ties are broken by the key: the order of a hash map must not show in the result.
    auto farthest = tiles_.end();
    std::pair<long, std::uint64_t> worst{-1, 0};
    for (auto tile = tiles_.begin(); tile != tiles_.end(); ++tile)
    {
      const Eigen::Vector3i offset =
          kTileCells * tile->second->at + Eigen::Vector3i::Constant(kTileCells / 2) - around_cell;
      const std::pair<long, std::uint64_t> rank{offset.cast<long>().squaredNorm(), tile->first};
      if (rank > worst) worst = rank, farthest = tile;
    }
    bytes_ -= farthest->second->tree.bytes();
    tiles_.erase(farthest);
  }
}

bool OctreeRecord::writeFile(const std::filesystem::path& file,
                             const std::function<void(const BrickSink&)>& newer) const
{
  RecordTree joined(resolution_);
  joined.setOccupancyThres(occupied_threshold_);
  for (const auto& [key, tile] : tiles_)
    for (int z = 0; z < kTileBricks; ++z)
      for (int y = 0; y < kTileBricks; ++y)
        for (int x = 0; x < kTileBricks; ++x)
        {
          const Eigen::Vector3i at = kTileBricks * tile->at + Eigen::Vector3i(x, y, z);
          const Brick brick = tile->tree.read(at);
          if (brick.known != 0) joined.write(at, brick);
        }
  newer(
      [&joined](const Eigen::Vector3i& at, const Brick& brick)
      {
        if (brick.known != 0 && representable(at)) joined.write(at, brick);
      });
  joined.updateInnerOccupancy();
  return writeAtomically(file, joined);
}

}  // namespace slalom::mapping::detail
