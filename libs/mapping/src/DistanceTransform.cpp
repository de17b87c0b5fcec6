// SPDX-License-Identifier: BSD-3-Clause
#include "DistanceTransform.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <stdexcept>
#include <string>

#include "slalom/core/DistanceField.h"

#define SLALOM_INLINE inline __attribute__((always_inline))

namespace slalom::mapping::detail
{
namespace
{
constexpr int kBlock = 64;  // cells of x that the pass along z handles together: fits L1

struct Job
{
  GridShape shape;
  int saturation;
  int radius;
  bool outside_is_obstacle;
  std::int16_t* scratch;
  [[nodiscard]] int pad() const { return (radius + kLanes) / kLanes * kLanes; }
};

// Vectors of the compiler's own extension: they compile for any processor, the width is a template
// argument so that one source serves several instruction sets.
template <int Bytes>
struct Simd
{
  static constexpr int kWidth = Bytes / 2;
  typedef std::int16_t V __attribute__((vector_size(Bytes)));
  typedef std::uint8_t U8 __attribute__((vector_size(Bytes / 2)));

  static SLALOM_INLINE void load(V& v, const std::int16_t* p) { std::memcpy(&v, p, sizeof(V)); }
  static SLALOM_INLINE void store(std::int16_t* p, const V& v) { std::memcpy(p, &v, sizeof(V)); }
  static SLALOM_INLINE void lower(V& a, const V& b) { a = a < b ? a : b; }
  static SLALOM_INLINE bool any(const V& mask)
  {
    std::uint64_t words[Bytes / 8];
    std::memcpy(words, &mask, sizeof(V));
    std::uint64_t all = 0;
    for (int i = 0; i < Bytes / 8; ++i) all |= words[i];
    return all != 0;
  }
};

std::int16_t i16(int value)
{
  return static_cast<std::int16_t>(value);
}

// out[i] = min over |k| <= radius of in[i + k*stride] + k^2, for one vector of cells.
template <int Bytes>
SLALOM_INLINE void envelope(const std::int16_t* in, std::ptrdiff_t stride, int radius,
                            typename Simd<Bytes>::V& best)
{
  using S = Simd<Bytes>;
  S::load(best, in);
  const std::int16_t* below = in;
  const std::int16_t* above = in;
  for (int k = 1; k <= radius; k += 2)
  {
    // No cell farther than k can lower a value of at most k^2.
    if (!S::any(best > i16(k * k))) return;
    for (int j = k; j < k + 2; ++j)
    {
      typename S::V a, b;
      S::load(a, below -= stride);
      S::load(b, above += stride);
      S::lower(a, b);
      a += i16(j * j);
      S::lower(best, a);
    }
  }
}

// Signed squared distances along y of one slab (fixed z), written to `slab`.
template <int Bytes>
SLALOM_INLINE void passY(const Job& job, const std::uint8_t* occupancy, std::int16_t* slab)
{
  using S = Simd<Bytes>;
  using V = typename S::V;
  const int pitch = job.shape.pitch(), ny = job.shape.size.y();
  const V zero = V{};
  const V far = zero + i16(job.radius + 1);
  const V cap = zero + i16(job.saturation);
  const std::uint8_t first_free = static_cast<std::uint8_t>(core::Occupancy::Free);
  const std::uint8_t taken = static_cast<std::uint8_t>(core::Occupancy::Occupied);
  for (int x = 0; x < pitch; x += S::kWidth)
  {
    V out = job.outside_is_obstacle ? zero : far;  // cells since the last obstacle
    V in = job.outside_is_obstacle ? far : zero;   // cells since the last one that is none
    for (int y = 0; y < ny; ++y)
    {
      typename S::U8 bytes;
      std::memcpy(&bytes, occupancy + static_cast<std::size_t>(y) * pitch + x, sizeof(bytes));
      const V value = __builtin_convertvector(bytes, V);
      const V obstacle =
          job.outside_is_obstacle ? (value != i16(first_free)) : (value == i16(taken));
      out += i16(1), in += i16(1);
      S::lower(out, far), S::lower(in, far);
      out = obstacle ? zero : out;
      in = obstacle ? in : zero;
      S::store(slab + static_cast<std::size_t>(y) * pitch + x, out - in);
    }
    out = job.outside_is_obstacle ? zero : far;
    in = job.outside_is_obstacle ? far : zero;
    for (int y = ny - 1; y >= 0; --y)
    {
      std::int16_t* cell = slab + static_cast<std::size_t>(y) * pitch + x;
      V seen;
      S::load(seen, cell);
      const V obstacle = seen < zero;
      out += i16(1), in += i16(1);
      S::lower(out, far), S::lower(in, far);
      out = obstacle ? zero : out;
      in = obstacle ? in : zero;
      V steps = obstacle ? -seen : seen;
      S::lower(steps, out + in);  // one of the two is zero
      V squared = steps * steps;
      S::lower(squared, cap);
      S::store(cell, obstacle ? -squared : squared);
    }
  }
}

// What a line of cells contains decides which of the two transforms it needs.
struct Content
{
  bool outside = false, inside = false;  // cells of either kind
};

// Splits signed distances into those of free cells and those of obstacle cells.
template <int Bytes>
SLALOM_INLINE void split(const std::int16_t* from, int count, std::int16_t* out, std::int16_t* in,
                         typename Simd<Bytes>::V& any_out, typename Simd<Bytes>::V& any_in)
{
  using S = Simd<Bytes>;
  const typename S::V zero{};
  for (int x = 0; x < count; x += S::kWidth)
  {
    typename S::V value;
    S::load(value, from + x);
    const typename S::V positive = value > zero ? value : zero;
    const typename S::V negative = positive - value;
    any_out |= positive;
    any_in |= negative;
    S::store(out + x, positive);
    S::store(in + x, negative);
  }
}

// Envelope of one or both kinds for one vector of cells, joined to a signed value again.
template <int Bytes>
SLALOM_INLINE void joined(const std::int16_t* out, const std::int16_t* in, std::ptrdiff_t stride,
                          int radius, const Content& content, std::int16_t* to)
{
  using S = Simd<Bytes>;
  typename S::V value{}, depth{};
  if (content.outside) envelope<Bytes>(out, stride, radius, value);
  if (content.inside)
  {
    envelope<Bytes>(in, stride, radius, depth);
    value -= depth;
  }
  S::store(to, value);
}

template <int Bytes>
SLALOM_INLINE void passX(const Job& job, const std::int16_t* slab, std::int16_t* result)
{
  using S = Simd<Bytes>;
  const int nx = job.shape.size.x(), ny = job.shape.size.y(), pitch = job.shape.pitch();
  const int pad = job.pad(), line = pad + pitch + pad;
  std::int16_t* out = job.scratch;
  std::int16_t* in = out + line;
  const std::int16_t pad_out = job.outside_is_obstacle ? 0 : i16(job.saturation);
  const std::int16_t pad_in = job.outside_is_obstacle ? i16(job.saturation) : 0;
  std::fill_n(out, line, pad_out);
  std::fill_n(in, line, pad_in);
  for (int y = 0; y < ny; ++y)
  {
    typename S::V any_out{}, any_in{};
    const std::size_t row = static_cast<std::size_t>(y) * pitch;
    split<Bytes>(slab + row, pitch, out + pad, in + pad, any_out, any_in);
    std::fill(out + pad + nx, out + pad + pitch, pad_out);
    std::fill(in + pad + nx, in + pad + pitch, pad_in);
    const Content content{S::any(any_out), S::any(any_in)};
    for (int x = 0; x < nx; x += S::kWidth)
      joined<Bytes>(out + pad + x, in + pad + x, 1, job.radius, content, result + row + x);
  }
}

template <int Bytes>
SLALOM_INLINE void passZ(const Job& job, std::int16_t* result)
{
  using S = Simd<Bytes>;
  const int ny = job.shape.size.y(), nz = job.shape.size.z(), pitch = job.shape.pitch();
  const int pad = job.pad();
  const std::size_t column = static_cast<std::size_t>(pad + nz + pad) * kBlock;
  std::int16_t* out = job.scratch;
  std::int16_t* in = out + column;
  std::fill_n(out, column, job.outside_is_obstacle ? std::int16_t{0} : i16(job.saturation));
  std::fill_n(in, column, job.outside_is_obstacle ? i16(job.saturation) : std::int16_t{0});
  for (int y = 0; y < ny; ++y)
    for (int x0 = 0; x0 < pitch; x0 += kBlock)
    {
      const int width = std::min(kBlock, pitch - x0);
      typename S::V any_out{}, any_in{};
      for (int z = 0; z < nz; ++z)
        split<Bytes>(result + job.shape.row(y, z) + x0, width, out + (pad + z) * kBlock,
                     in + (pad + z) * kBlock, any_out, any_in);
      const Content content{S::any(any_out), S::any(any_in)};
      for (int z = 0; z < nz; ++z)
        for (int x = 0; x < width; x += S::kWidth)
          joined<Bytes>(out + (pad + z) * kBlock + x, in + (pad + z) * kBlock + x, kBlock,
                        job.radius, content, result + job.shape.row(y, z) + x0 + x);
    }
}

template <int Bytes>
SLALOM_INLINE void transform(const Job& job, const std::uint8_t* occupancy, std::int16_t* result)
{
  const std::size_t slab_cells = job.shape.row(0, 1);
  std::int16_t* slab = job.scratch;
  Job rest = job;
  rest.scratch += slab_cells;
  for (int z = 0; z < job.shape.size.z(); ++z)
  {
    passY<Bytes>(job, occupancy + z * slab_cells, slab);
    passX<Bytes>(rest, slab, result + z * slab_cells);
  }
  passZ<Bytes>(rest, result);
}

void transformPortable(const Job& job, const std::uint8_t* occupancy, std::int16_t* result)
{
  transform<16>(job, occupancy, result);
}

#if defined(__x86_64__)
__attribute__((target("avx2"))) void transformAvx2(const Job& job, const std::uint8_t* occupancy,
                                                   std::int16_t* result)
{
  transform<32>(job, occupancy, result);
}
#endif

void transformBest(const Job& job, const std::uint8_t* occupancy, std::int16_t* result)
{
#if defined(__x86_64__)
  static const bool has_avx2 = __builtin_cpu_supports("avx2") != 0;
  if (has_avx2) return transformAvx2(job, occupancy, result);
#endif
  transformPortable(job, occupancy, result);
}

}  // namespace

DistanceTransform::DistanceTransform(const GridShape& shape, int saturation)
    : shape_(shape), saturation_(saturation)
{
  if (saturation < 1 || saturation > kMaxSaturation)
    throw std::invalid_argument("distance transform: the squared saturation of " +
                                std::to_string(saturation) + " cells is outside 1.." +
                                std::to_string(kMaxSaturation));
  radius_ = 0;
  while ((radius_ + 1) * (radius_ + 1) < saturation) ++radius_;
  const std::size_t pad = (radius_ + kLanes) / kLanes * kLanes;
  const std::size_t lines = 2 * (2 * pad + shape.pitch());
  const std::size_t columns = 2 * kBlock * (2 * pad + shape.size.z());
  scratch_.resize(shape.row(0, 1) + std::max(lines, columns));
}

void DistanceTransform::run(const std::uint8_t* occupancy, std::int16_t* optimistic,
                            std::int16_t* pessimistic)
{
  transformBest({shape_, saturation_, radius_, false, scratch_.data()}, occupancy, optimistic);
  transformBest({shape_, saturation_, radius_, true, scratch_.data()}, occupancy, pessimistic);
}

}  // namespace slalom::mapping::detail
