// SPDX-License-Identifier: BSD-3-Clause
#include "OctreeFile.h"

#include <cmath>
#include <cstring>
#include <fstream>
#include <stdexcept>
#include <string>

#include "slalom/core/TextTable.h"

namespace slalom::simulation::detail
{
namespace
{
constexpr int kDepth = 16;                  // of every OctoMap tree
constexpr int kOrigin = 1 << (kDepth - 1);  // key of the voxel at the world's origin
constexpr char kBinaryTitle[] = "# Octomap OcTree binary file";
constexpr char kFullTitle[] = "# Octomap OcTree file";

struct Header
{
  bool binary = false;
  std::uint64_t nodes = 0;
  double resolution = 0.0;
};

class TreeReader
{
 public:
  TreeReader(std::istream& stream, const std::string& name) : stream_(stream), name_(name) {}

  Header header()
  {
    Header header;
    const std::string title = line();
    if (title.starts_with(kBinaryTitle))
      header.binary = true;
    else if (!title.starts_with(kFullTitle))
      fail(1, "not an OctoMap file, it starts with '" + title.substr(0, 40) + "'");
    std::string id;
    for (std::string text = line(); text != "data"; text = line())
    {
      if (text.empty() || text[0] == '#') continue;
      const std::size_t space = text.find(' ');
      const std::string key = text.substr(0, space);
      const std::string value = space == std::string::npos ? "" : text.substr(space + 1);
      if (key == "id") id = value;
      if (key == "size") header.nodes = static_cast<std::uint64_t>(number(value));
      if (key == "res") header.resolution = number(value);
    }
    if (id != "OcTree") fail(line_, "tree of type '" + id + "', only OcTree can be read");
    if (!(header.resolution > 0.0) || header.resolution > 100.0)
      fail(line_, "resolution " + std::to_string(header.resolution) + " m is not in (0, 100]");
    return header;
  }

  OctreeLeaves leaves(const Header& header)
  {
    result_.resolution = header.resolution;
    if (header.nodes > 0)
    {
      nodes_ = 1;
      const Eigen::Vector3i corner = Eigen::Vector3i::Constant(-kOrigin);
      header.binary ? binaryNode(corner, kDepth) : fullNode(corner, kDepth);
    }
    if (nodes_ != header.nodes)
      damaged("holds " + std::to_string(nodes_) + " nodes where its header says " +
              std::to_string(header.nodes));
    return std::move(result_);
  }

 private:
  std::string line()
  {
    std::string text;
    ++line_;
    if (line_ > 100 || !std::getline(stream_, text)) fail(line_, "no 'data' line in the header");
    if (!text.empty() && text.back() == '\r') text.pop_back();
    return text;
  }
  double number(const std::string& text)
  {
    const std::optional<double> value = core::parseNumber(text);
    if (!value || *value < 0.0) fail(line_, "malformed number '" + text + "'");
    return *value;
  }
  [[noreturn]] void fail(int at, const std::string& what) const
  {
    throw std::runtime_error(name_ + ":" + std::to_string(at) + ": " + what);
  }
  [[noreturn]] void damaged(const std::string& what) const
  {
    throw std::runtime_error(name_ + ": damaged octree: " + what);
  }
  void read(void* to, std::size_t bytes)
  {
    if (!stream_.read(static_cast<char*>(to), static_cast<std::streamsize>(bytes)))
      damaged("it ends after " + std::to_string(nodes_) + " nodes");
  }
  static Eigen::Vector3i childCorner(const Eigen::Vector3i& corner, int child, int levels)
  {
    const int half = 1 << (levels - 1);
    return corner + half * Eigen::Vector3i(child & 1, (child >> 1) & 1, (child >> 2) & 1);
  }

  /// Two bits per child: 00 unknown, 01 occupied, 10 free, 11 inner (first bit is the lower).
  void binaryNode(const Eigen::Vector3i& corner, int levels)
  {
    if (levels == 0) damaged("deeper than 16 levels");
    std::uint8_t bytes[2];
    read(bytes, 2);
    const unsigned flags = bytes[0] | static_cast<unsigned>(bytes[1]) << 8;
    for (int child = 0; child < 8; ++child)
    {
      const unsigned kind = (flags >> (2 * child)) & 3u;
      if (kind == 0) continue;
      ++nodes_;
      if (kind != 3)
        result_.leaves.push_back(
            {childCorner(corner, child, levels), 1 << (levels - 1), kind == 2});
    }
    for (int child = 0; child < 8; ++child)
      if (((flags >> (2 * child)) & 3u) == 3u)
        binaryNode(childCorner(corner, child, levels), levels - 1);
  }

  /// Log-odds as float, then one bit per child; a node without children is a leaf.
  void fullNode(const Eigen::Vector3i& corner, int levels)
  {
    float log_odds = 0.0f;
    std::uint8_t children = 0;
    read(&log_odds, sizeof(log_odds));
    read(&children, 1);
    if (children == 0)
    {
      result_.leaves.push_back({corner, 1 << levels, log_odds >= 0.0f});
      return;
    }
    if (levels == 0) damaged("deeper than 16 levels");
    for (int child = 0; child < 8; ++child)
    {
      if (((children >> child) & 1) == 0) continue;
      ++nodes_;
      fullNode(childCorner(corner, child, levels), levels - 1);
    }
  }

  std::istream& stream_;
  std::string name_;
  int line_ = 0;
  std::uint64_t nodes_ = 0;
  OctreeLeaves result_;
};
}  // namespace

OctreeLeaves readOctree(const std::filesystem::path& file)
{
  std::ifstream stream(file, std::ios::binary);
  if (!stream) throw std::runtime_error(file.string() + ": cannot be read");
  TreeReader reader(stream, file.string());
  const Header header = reader.header();
  return reader.leaves(header);
}

}  // namespace slalom::simulation::detail
