// SPDX-License-Identifier: BSD-3-Clause
#include "DistanceTransform.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <stdexcept>
#include <string>

#include "slalom/core/DistanceField.h"

#if defined(__x86_64__)
#include <immintrin.h>
#endif

namespace slalom::mapping::detail
{
namespace
{
constexpr int kUnroll = 4;  // steps between two looks at whether to go on

// Of kLanes cells: whether any is of the kind in question, and whether any distance of that kind is
// below the saturation, so that it can lower others.
struct Traits
{
  bool present = false, seeds = false;
};

struct Job
{
  GridShape shape;
  int saturation;
  int radius;
  int pad;  // cells on either side of a line, so that no step needs a bounds check
  bool outside_is_obstacle;
  const std::int16_t* squares;
  std::int16_t* scratch;
  // Of the groups of kLanes cells along a line, with one more at each end for the outside.
  Traits *traits_out, *traits_in;
  int *nearest_out, *nearest_in;

  // Finds for each of n groups how many groups away the nearest one with seeds is.
  void mark(int n) const
  {
    nearest(n, outside_is_obstacle, traits_out, nearest_out);
    nearest(n, !outside_is_obstacle, traits_in, nearest_in);
  }
  static void nearest(int n, bool outside, const Traits* traits, int* result)
  {
    constexpr int kFar = 1 << 20;
    result[0] = result[n + 1] = outside ? 0 : kFar;
    for (int i = 1; i <= n; ++i) result[i] = traits[i].seeds ? 0 : result[i - 1] + 1;
    for (int i = n; i >= 1; --i) result[i] = std::min(result[i], result[i + 1] + 1);
  }
};

std::int16_t i16(int value)
{
  return static_cast<std::int16_t>(value);
}

#define SLALOM_KERNEL "DistanceTransformKernel.inl"
#include "ForEachInstructionSet.inl"
#undef SLALOM_KERNEL

using Transform = void (*)(const Job&, const std::uint8_t*, std::int16_t*);

Transform transformFor([[maybe_unused]] InstructionSet set)
{
#if defined(__x86_64__)
  if (set == InstructionSet::Avx512) return &avx512::transform;
  if (set == InstructionSet::Avx2) return &avx2::transform;
#endif
  return &portable::transform;
}

}  // namespace

DistanceTransform::DistanceTransform(const GridShape& shape, int saturation, InstructionSet set)
    : shape_(shape), saturation_(saturation), set_(set)
{
  if (saturation < 1 || saturation > kMaxSaturation)
    throw std::invalid_argument("distance transform: the squared saturation of " +
                                std::to_string(saturation) + " cells is outside 1.." +
                                std::to_string(kMaxSaturation));
  radius_ = 0;
  while ((radius_ + 1) * (radius_ + 1) < saturation) ++radius_;
  pad_ = (radius_ + kUnroll + kLanes) / kLanes * kLanes;
  const std::size_t lines = 2 * (2 * pad_ + shape.pitch());
  const std::size_t columns = 2 * static_cast<std::size_t>(kLanes) * (2 * pad_ + shape.size.z());
  scratch_.resize(shape.row(0, 1) + std::max(lines, columns));
  for (int k = 0; k <= radius_ + kUnroll; ++k) squares_.insert(squares_.end(), kLanes, i16(k * k));
}

void DistanceTransform::run(const std::uint8_t* occupancy, std::int16_t* optimistic,
                            std::int16_t* pessimistic)
{
  const Transform transform = transformFor(set_);
  const std::size_t groups = 2 + std::max(shape_.pitch() / kLanes, shape_.size.z());
  std::vector<Traits> traits(2 * groups);
  std::vector<int> nearest(2 * groups);
  Job job{shape_,
          saturation_,
          radius_,
          pad_,
          false,
          squares_.data(),
          scratch_.data(),
          traits.data(),
          traits.data() + groups,
          nearest.data(),
          nearest.data() + groups};
  transform(job, occupancy, optimistic);
  job.outside_is_obstacle = true;
  transform(job, occupancy, pessimistic);
}

}  // namespace slalom::mapping::detail
