// SPDX-License-Identifier: BSD-3-Clause
// The vector kernels give the same bits on every instruction set of this processor.
#include <gtest/gtest.h>

#include <algorithm>

#include "DistanceTransform.h"
#include "LineTraversal.h"
#include "slalom/core/Rng.h"

namespace
{
using namespace slalom::mapping::detail;
using slalom::core::Rng;

TEST(Kernels, DistanceTransformIsTheSameOnEveryInstructionSet)
{
  for (std::uint64_t seed = 0; seed < 30; ++seed)
  {
    SCOPED_TRACE(seed);
    Rng rng(seed);
    const GridShape shape{
        Eigen::Vector3i(rng.integer(2, 100), rng.integer(2, 40), rng.integer(2, 40))};
    const int saturations[] = {1, 2, 5, 50, 241, 931, DistanceTransform::kMaxSaturation};
    const int saturation = saturations[seed % 7];
    std::vector<std::uint8_t> occupancy(shape.cells());
    const double free = rng.uniform(0.5, 1.0), taken = rng.uniform(0.0, 0.02);
    for (std::uint8_t& cell : occupancy)
      cell = rng.uniform() < taken ? 2 : (rng.uniform() < free ? 1 : 0);
    std::vector<std::int16_t> reference[2], result[2];
    for (auto* arrays : {&reference, &result})
      for (auto& array : *arrays) array.assign(shape.cells(), 0);
    DistanceTransform(shape, saturation, InstructionSet::Portable)
        .run(occupancy.data(), reference[0].data(), reference[1].data());
    for (const InstructionSet set : instructionSets())
    {
      DistanceTransform(shape, saturation, set)
          .run(occupancy.data(), result[0].data(), result[1].data());
      for (int field = 0; field < 2; ++field)
        for (int z = 0; z < shape.size.z(); ++z)
          for (int y = 0; y < shape.size.y(); ++y)
            ASSERT_TRUE(std::equal(result[field].data() + shape.row(y, z),
                                   result[field].data() + shape.row(y, z) + shape.size.x(),
                                   reference[field].data() + shape.row(y, z)));
    }
  }
}

TEST(Kernels, LineTraversalIsTheSameOnEveryInstructionSet)
{
  constexpr std::int64_t kEdge = 64;
  for (std::uint64_t seed = 0; seed < 20; ++seed)
  {
    SCOPED_TRACE(seed);
    Rng rng(seed);
    std::vector<GridLine> lines;
    for (int i = rng.integer(1, 40); i > 0; --i)
    {
      GridLine line{};
      std::int64_t strides[] = {1, kEdge, kEdge * kEdge};
      line.steps = 1;
      for (int axis = 0; axis < 3; ++axis)
      {
        const int from = rng.integer(0, kEdge - 1), to = rng.integer(0, kEdge - 1);
        const double along = std::abs(to - from) + 1e-9;
        line.next[axis] = rng.uniform(0.2, 0.8) / along;
        line.gap[axis] = 1.0 / along;
        line.stride[axis] = to < from ? -strides[axis] : strides[axis];
        line.from += from * strides[axis];
        line.to += to * strides[axis];
        line.steps += std::abs(to - from);
      }
      line.length = 1.0;
      if (line.from != line.to) lines.push_back(line);
    }
    std::vector<std::uint8_t> reference;
    for (const InstructionSet set : instructionSets())
    {
      std::vector<std::uint8_t> grid(kEdge * kEdge * kEdge + 1, 0);
      traverse(lines, 1, grid.data(), kEdge * kEdge * kEdge, set);
      grid.back() = 0;
      if (reference.empty()) reference = grid;
      EXPECT_EQ(grid, reference);
      for (const GridLine& line : lines) EXPECT_EQ(grid[line.from], 1);
    }
  }
}

}  // namespace
