// SPDX-License-Identifier: BSD-3-Clause
// Traversal of lines for one instruction set, included by LineTraversal.cpp inside a namespace of
// its own with SLALOM_SIMD_BYTES = width of a vector. Only adds and compares: no instruction set
// may round differently from another.

constexpr int kLines = SLALOM_SIMD_BYTES / 8;
typedef double Reals __attribute__((vector_size(SLALOM_SIMD_BYTES)));
typedef std::int64_t Ints __attribute__((vector_size(SLALOM_SIMD_BYTES)));

inline void march(const GridLine* const (&lines)[kLines], int steps, std::uint8_t bit,
                  std::uint8_t* grid, std::int64_t spare)
{
  Reals next[3], gap[3], length;
  Ints stride[3], at, last;
  for (int i = 0; i < kLines; ++i)
  {
    const GridLine& line = *lines[i];
    for (int axis = 0; axis < 3; ++axis)
    {
      next[axis][i] = line.next[axis];
      gap[axis][i] = line.gap[axis];
      stride[axis][i] = line.stride[axis];
    }
    length[i] = line.length;
    at[i] = line.from;
    last[i] = line.to;
  }
  const Ints nowhere = Ints{} + spare;
  Ints alive = ~Ints{};
  const Reals zero{};
  for (int step = 0; step < steps; ++step)
  {
    const Ints to_mark = alive ? at : nowhere;
    for (int i = 0; i < kLines; ++i) grid[to_mark[i]] |= bit;
    // Ties go to z, then to y.
    const Ints x_first = next[0] < next[1];
    const Reals xy = x_first ? next[0] : next[1];
    const Ints z_step = next[2] <= xy;
    const Ints x_step = x_first & ~z_step;
    const Ints y_step = ~(x_first | z_step);
    next[0] += x_step ? gap[0] : zero;
    next[1] += y_step ? gap[1] : zero;
    next[2] += z_step ? gap[2] : zero;
    at += (x_step & stride[0]) + (y_step & stride[1]) + (z_step & stride[2]);
    const Reals near_xy = next[0] < next[1] ? next[0] : next[1];
    const Reals nearest = next[2] < near_xy ? next[2] : near_xy;
    alive &= (at != last) & (nearest <= length);
  }
}

inline void traverseAll(const GridLine* const* lines, std::size_t count, std::uint8_t bit,
                        std::uint8_t* grid, std::int64_t spare)
{
  for (std::size_t i = 0; i < count; i += kLines)
  {
    // A group that is not full repeats its last line, which does no harm.
    const GridLine* group[kLines];
    int steps = 0;
    for (int k = 0; k < kLines; ++k)
    {
      group[k] = lines[std::min(i + k, count - 1)];
      steps = std::max(steps, group[k]->steps);
    }
    march(group, steps, bit, grid, spare);
  }
}
