// SPDX-License-Identifier: BSD-3-Clause
// The passes of the distance transform for one instruction set. DistanceTransform.cpp includes this
// file once per set, inside a namespace of its own, with SLALOM_SIMD_BYTES = width of a vector.
// Vectors are the compiler's own extension, so the code compiles for any processor.

constexpr int kWidth = SLALOM_SIMD_BYTES / 2;
typedef std::int16_t Cells __attribute__((vector_size(SLALOM_SIMD_BYTES)));
typedef std::uint8_t Bytes __attribute__((vector_size(SLALOM_SIMD_BYTES / 2)));

inline void load(Cells& v, const std::int16_t* p) { std::memcpy(&v, p, sizeof(v)); }
inline void store(std::int16_t* p, const Cells& v) { std::memcpy(p, &v, sizeof(v)); }
inline void lower(Cells& a, const Cells& b) { a = a < b ? a : b; }

// Whether any cell is above a limit.
inline bool anyAbove(const Cells& v, const Cells& limit)
{
#if defined(__x86_64__) && SLALOM_SIMD_BYTES == 64
  return _mm512_cmpgt_epi16_mask((__m512i)v, (__m512i)limit) != 0;
#elif defined(__x86_64__) && SLALOM_SIMD_BYTES == 32
  return _mm256_movemask_epi8((__m256i)(v > limit)) != 0;
#elif defined(__x86_64__) && SLALOM_SIMD_BYTES == 16
  return _mm_movemask_epi8((__m128i)(v > limit)) != 0;
#else
  const Cells above = v > limit;
  std::uint64_t words[SLALOM_SIMD_BYTES / 8], all = 0;
  std::memcpy(words, &above, sizeof(above));
  for (const std::uint64_t word : words) all |= word;
  return all != 0;
#endif
}

// best[i] = min over |k| <= radius of in[i + k*stride] + k^2, for kLanes cells, given that nothing
// nearer than `first` helps. The loop stops where no cell is left that something k away could
// improve; looking at that costs as much as a step, hence only every kUnroll steps.
inline void envelope(const Job& job, const std::int16_t* in, std::ptrdiff_t stride, int first,
                     Cells (&best)[kLanes / kWidth])
{
  constexpr int kVectors = kLanes / kWidth;
  Cells worst;
  for (int v = 0; v < kVectors; ++v)
  {
    load(best[v], in + v * kWidth);
    worst = v == 0 ? best[v] : (worst > best[v] ? worst : best[v]);
  }
  const int before = std::max(0, first - 1);
  const std::int16_t* below = in - before * stride;
  const std::int16_t* above = in + before * stride;
  const std::int16_t* square = job.squares + before * kLanes;  // k^2, kLanes times each
  for (int k = before; k < job.radius; k += kUnroll)
  {
    Cells limit;
    load(limit, square);
    if (!anyAbove(worst, limit)) return;
    for (int j = 0; j < kUnroll; ++j)
    {
      below -= stride;
      above += stride;
      square += kLanes;
      Cells k2;
      load(k2, square);
      for (int v = 0; v < kVectors; ++v)
      {
        Cells a, b;
        load(a, below + v * kWidth);
        load(b, above + v * kWidth);
        lower(a, b);
        a += k2;
        lower(best[v], a);
      }
    }
    worst = best[0];
    for (int v = 1; v < kVectors; ++v) worst = worst > best[v] ? worst : best[v];
  }
}

// Signed squared distances along y of one slab (fixed z), written to `slab`.
inline void passY(const Job& job, const std::uint8_t* occupancy, std::int16_t* slab)
{
  const int pitch = job.shape.pitch(), ny = job.shape.size.y();
  const Cells zero{};
  const Cells far = zero + i16(job.radius + 1);
  const Cells cap = zero + i16(job.saturation);
  const Cells free = zero + i16(static_cast<int>(core::Occupancy::Free));
  const Cells taken = zero + i16(static_cast<int>(core::Occupancy::Occupied));
  for (int x = 0; x < pitch; x += kWidth)
  {
    Cells out = job.outside_is_obstacle ? zero : far;  // cells since the last obstacle
    Cells in = job.outside_is_obstacle ? far : zero;   // cells since the last one that is none
    for (int y = 0; y < ny; ++y)
    {
      Bytes bytes;
      std::memcpy(&bytes, occupancy + static_cast<std::size_t>(y) * pitch + x, sizeof(bytes));
      const Cells value = __builtin_convertvector(bytes, Cells);
      const Cells obstacle = job.outside_is_obstacle ? (value != free) : (value == taken);
      out += i16(1), in += i16(1);
      lower(out, far), lower(in, far);
      out = obstacle ? zero : out;
      in = obstacle ? in : zero;
      store(slab + static_cast<std::size_t>(y) * pitch + x, out - in);
    }
    out = job.outside_is_obstacle ? zero : far;
    in = job.outside_is_obstacle ? far : zero;
    for (int y = ny - 1; y >= 0; --y)
    {
      std::int16_t* cell = slab + static_cast<std::size_t>(y) * pitch + x;
      Cells seen;
      load(seen, cell);
      const Cells obstacle = seen < zero;
      out += i16(1), in += i16(1);
      lower(out, far), lower(in, far);
      out = obstacle ? zero : out;
      in = obstacle ? in : zero;
      Cells steps = obstacle ? -seen : seen;
      lower(steps, out + in);  // one of the two is zero
      Cells squared = steps * steps;
      lower(squared, cap);
      store(cell, obstacle ? -squared : squared);
    }
  }
}

// Splits signed distances of kLanes cells into those of free cells and those of obstacle cells, and
// notes for either kind whether there are such cells and whether any distance is not saturated.
inline void split(const Job& job, const std::int16_t* from, std::int16_t* out, std::int16_t* in,
                  Traits& traits_out, Traits& traits_in)
{
  const Cells zero{};
  const Cells cap = zero + i16(job.saturation);
  Cells most_out{}, most_in{}, least_out = cap, least_in = cap;
  for (int x = 0; x < kLanes; x += kWidth)
  {
    Cells value;
    load(value, from + x);
    const Cells positive = value > zero ? value : zero;
    const Cells negative = positive - value;
    most_out |= positive;
    most_in |= negative;
    lower(least_out, positive);
    lower(least_in, negative);
    store(out + x, positive);
    store(in + x, negative);
  }
  traits_out = {anyAbove(most_out, zero), anyAbove(cap, least_out)};
  traits_in = {anyAbove(most_in, zero), anyAbove(cap, least_in)};
}

// Envelopes of both kinds for kLanes cells, joined to signed values again. `first_out`, `first_in`:
// how far away the nearest unsaturated cells are; beyond the radius, or without cells of a kind,
// there is nothing to do.
inline void joined(const Job& job, const std::int16_t* out, const std::int16_t* in,
                   std::ptrdiff_t stride, const Traits& traits_out, int first_out,
                   const Traits& traits_in, int first_in, std::int16_t* to)
{
  constexpr int kVectors = kLanes / kWidth;
  Cells value[kVectors] = {}, depth[kVectors] = {};
  if (traits_out.present) envelope(job, out, stride, first_out, value);
  if (traits_in.present) envelope(job, in, stride, first_in, depth);
  for (int v = 0; v < kVectors; ++v) store(to + v * kWidth, value[v] - depth[v]);
}

inline void passX(const Job& job, const std::int16_t* slab, std::int16_t* result)
{
  const int nx = job.shape.size.x(), ny = job.shape.size.y(), pitch = job.shape.pitch();
  const int line = job.pad + pitch + job.pad;
  std::int16_t* out = job.scratch;
  std::int16_t* in = out + line;
  const std::int16_t pad_out = job.outside_is_obstacle ? 0 : i16(job.saturation);
  const std::int16_t pad_in = job.outside_is_obstacle ? i16(job.saturation) : 0;
  std::fill_n(out, line, pad_out);
  std::fill_n(in, line, pad_in);
  const int blocks = pitch / kLanes, reach = job.pad / kLanes;
  for (int y = 0; y < ny; ++y)
  {
    const std::size_t row = static_cast<std::size_t>(y) * pitch;
    for (int b = 0; b < blocks; ++b)
      split(job, slab + row + b * kLanes, out + job.pad + b * kLanes, in + job.pad + b * kLanes,
            job.traits_out[b + 1], job.traits_in[b + 1]);
    std::fill(out + job.pad + nx, out + job.pad + pitch, pad_out);
    std::fill(in + job.pad + nx, in + job.pad + pitch, pad_in);
    job.mark(blocks);
    for (int b = 0; b < blocks; ++b)
    {
      // In blocks: 0 if this one has unsaturated cells, else the nearest edge of one that has.
      const int near_out = job.nearest_out[b + 1], near_in = job.nearest_in[b + 1];
      const int far = (reach + 1) * kLanes;
      joined(job, out + job.pad + b * kLanes, in + job.pad + b * kLanes, 1, job.traits_out[b + 1],
             near_out > reach ? far : (near_out > 1 ? (near_out - 1) * kLanes : 0),
             job.traits_in[b + 1],
             near_in > reach ? far : (near_in > 1 ? (near_in - 1) * kLanes : 0),
             result + row + b * kLanes);
    }
  }
}

inline void passZ(const Job& job, std::int16_t* result)
{
  const int ny = job.shape.size.y(), nz = job.shape.size.z(), pitch = job.shape.pitch();
  const std::size_t column = static_cast<std::size_t>(job.pad + nz + job.pad) * kLanes;
  std::int16_t* out = job.scratch;
  std::int16_t* in = out + column;
  std::fill_n(out, column, job.outside_is_obstacle ? std::int16_t{0} : i16(job.saturation));
  std::fill_n(in, column, job.outside_is_obstacle ? i16(job.saturation) : std::int16_t{0});
  for (int y = 0; y < ny; ++y)
    for (int x = 0; x < pitch; x += kLanes)
    {
      for (int z = 0; z < nz; ++z)
        split(job, result + job.shape.row(y, z) + x, out + (job.pad + z) * kLanes,
              in + (job.pad + z) * kLanes, job.traits_out[z + 1], job.traits_in[z + 1]);
      job.mark(nz);
      for (int z = 0; z < nz; ++z)
        joined(job, out + (job.pad + z) * kLanes, in + (job.pad + z) * kLanes, kLanes,
               job.traits_out[z + 1], job.nearest_out[z + 1], job.traits_in[z + 1],
               job.nearest_in[z + 1], result + job.shape.row(y, z) + x);
    }
}

inline void transform(const Job& job, const std::uint8_t* occupancy, std::int16_t* result)
{
  const std::size_t slab_cells = job.shape.row(0, 1);
  std::int16_t* slab = job.scratch;
  Job rest = job;
  rest.scratch += slab_cells;
  for (int z = 0; z < job.shape.size.z(); ++z)
  {
    passY(job, occupancy + z * slab_cells, slab);
    passX(rest, slab, result + z * slab_cells);
  }
  passZ(rest, result);
}
