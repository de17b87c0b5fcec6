// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>

namespace slalom::mapping::detail
{
/** A cube of 4 x 4 x 4 cells, aligned to the octree: the unit in which the window and the octree
 * exchange cells. One brick is one subtree of two levels, so the way down from the root is paid
 * once per 64 cells. */
struct Brick
{
  static constexpr int kEdge = 4;
  static constexpr int kCells = kEdge * kEdge * kEdge;

  std::uint64_t known = 0;               ///< bit i: cell i has been seen
  std::array<float, kCells> log_odds{};  ///< of known cells

  /// Index of a cell by its coordinates 0..3 in the brick, x fastest.
  [[nodiscard]] static constexpr int index(int x, int y, int z)
  {
    return x + kEdge * (y + kEdge * z);
  }
};

/// Key of an integer position for hash maps; positions within +-2^20.
[[nodiscard]] inline std::uint64_t packed(const Eigen::Vector3i& p)
{
  constexpr std::uint64_t kMask = (1u << 21) - 1;
  return (static_cast<std::uint64_t>(p.x()) & kMask) |
         (static_cast<std::uint64_t>(p.y()) & kMask) << 21 |
         (static_cast<std::uint64_t>(p.z()) & kMask) << 42;
}

/// Quotient rounded down.
[[nodiscard]] constexpr int floorDiv(int a, int b)
{
  return a / b - (a % b < 0 ? 1 : 0);
}

}  // namespace slalom::mapping::detail
